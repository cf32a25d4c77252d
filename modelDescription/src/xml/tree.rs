//! A parsed document as a tree of elements: all that descriptions consist of.

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// Deepest nesting that is read; the schema needs five levels.
const DEEPEST: usize = 64;

/// Most attributes of an element that are read; the schema knows no element with twenty.
const MOST_ATTRIBUTES: usize = 256;

/// An element with its attributes and child elements; text and comments are not kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) attributes: Vec<(String, String)>,
    pub(super) children: Vec<Element>,
    /// Line of its start tag's end, from 1.
    pub(super) line: usize,
}

/// Why a document has no tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Malformed {
    pub(super) line: usize,
    pub(super) reason: String,
}

impl Element {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        let mut attributes = self.attributes.iter();
        attributes.find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub(super) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// Children of the child of that name; none if it is missing.
    pub(super) fn list(&self, name: &str) -> &[Self] {
        self.child(name).map_or(&[], |child| &child.children)
    }
}

/// Whether XML 1.0 has no such character, not even by its number (2.2).
fn is_forbidden(c: char) -> bool {
    matches!(c, '\0'..='\x08' | '\x0b' | '\x0c' | '\x0e'..='\x1f' | '\u{fffe}' | '\u{ffff}')
}

/// The first character of `text` that no document may have, as a sentence.
fn forbidden(text: &str) -> Option<String> {
    let found = text.chars().find(|&c| is_forbidden(c))?;
    Some(format!("the character U+{:04X}, which no XML may have", u32::from(found)))
}

/// Parses a document; returns its root.
pub(super) fn parse(xml: &str) -> Result<Element, Malformed> {
    if let Some((place, _)) = xml.char_indices().find(|&(_, c)| is_forbidden(c)) {
        let (before, from) = xml.split_at(place);
        let line = before.matches('\n').count() + 1;
        return Err(Malformed { line, reason: forbidden(from).unwrap_or_default() });
    }
    let mut reader = Reader::from_str(xml);
    // The elements that are open; the document itself is the first.
    let mut open = vec![Element::default()];
    let (mut line, mut counted) = (1, 0);
    loop {
        let event = reader.read_event();
        let position = usize::try_from(reader.buffer_position()).unwrap_or(xml.len());
        let read = xml.as_bytes().get(counted..position).unwrap_or(&[]);
        line += read.iter().filter(|&&byte| byte == b'\n').count();
        counted = position.max(counted);
        let malformed = |reason: String| Malformed { line, reason };

        match event.map_err(|error| malformed(error.to_string()))? {
            Event::Start(tag) => {
                if open.len() > DEEPEST {
                    return Err(malformed(format!("elements nested more than {DEEPEST} deep")));
                }
                open.push(element(&tag, line)?);
            }
            Event::Empty(tag) => {
                let element = element(&tag, line)?;
                open.last_mut()
                    .into_iter()
                    .for_each(|parent| parent.children.push(element.clone()));
            }
            Event::End(_) => {
                // The reader has checked that the tag closes the last open element.
                if let Some(element) = open.pop()
                    && let Some(parent) = open.last_mut()
                {
                    parent.children.push(element);
                }
            }
            Event::Eof if open.len() == 1 => {
                let roots = open.pop().map(|document| document.children).unwrap_or_default();
                let [root] = <[Element; 1]>::try_from(roots)
                    .map_err(|roots| malformed(format!("{} root elements", roots.len())))?;
                return Ok(root);
            }
            Event::Eof => return Err(malformed("an element is not closed".to_owned())),
            _ => {}
        }
    }
}

fn element(tag: &BytesStart<'_>, line: usize) -> Result<Element, Malformed> {
    let malformed = |reason: String| Malformed { line, reason };
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        if attributes.len() == MOST_ATTRIBUTES {
            let reason = format!("an element with more than {MOST_ATTRIBUTES} attributes");
            return Err(malformed(reason));
        }
        let attribute = attribute.map_err(|error| malformed(error.to_string()))?;
        let value = attribute
            .normalized_value(quick_xml::XmlVersion::Implicit1_0)
            .map_err(|error| malformed(error.to_string()))?;
        // By its number.
        if let Some(reason) = forbidden(&value) {
            return Err(malformed(reason));
        }
        attributes.push((attribute.key.as_ref().to_owned(), value.into_owned()));
    }
    Ok(Element { name: tag.name().as_ref().to_owned(), attributes, children: Vec::new(), line })
}
