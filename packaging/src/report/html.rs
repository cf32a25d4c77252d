//! Pieces of a page. Text that comes from anywhere else goes through [`escaped`].

use std::fmt::Write as _;

/// A section of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// What links to it name.
    pub id: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What stands below.
    pub html: String,
}

/// `text` as it reads, whatever it holds.
pub fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\n' | '\t' => safe.push(character),
            // No page may hold these, and none is readable.
            control if control.is_control() => safe.push('\u{fffd}'),
            other => safe.push(other),
        }
    }
    safe
}

/// A paragraph of plain text.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// How a table's cells stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// Words, to the left.
    Words,
    /// Figures, to the right.
    Figures,
}

/// A table of plain text; the first row is the head. Wide ones scroll by themselves.
pub fn table(caption: &str, cells: Cells, rows: &[Vec<String>]) -> String {
    let head = rows.first().into_iter().flatten();
    let head: String = head.map(|x| format!("<th scope=\"col\">{}</th>", escaped(x))).collect();
    let mut body = String::new();
    for row in rows.iter().skip(1) {
        let cells: String = row.iter().map(|x| format!("<td>{}</td>", escaped(x))).collect();
        let _infallible = writeln!(body, "<tr>{cells}</tr>");
    }
    framed(caption, cells, &format!("<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>\n"))
}

/// A table of names and values.
pub fn pairs(caption: &str, rows: &[(String, String)]) -> String {
    let mut body = String::new();
    for (name, value) in rows {
        let (name, value) = (escaped(name), escaped(value));
        let _infallible = writeln!(body, "<tr><th scope=\"row\">{name}</th><td>{value}</td></tr>");
    }
    framed(caption, Cells::Words, &format!("<tbody>\n{body}</tbody>\n"))
}

/// A table around rows that are HTML already.
pub fn framed(caption: &str, cells: Cells, rows: &str) -> String {
    let class = if cells == Cells::Figures { " class=\"figures\"" } else { "" };
    let caption = escaped(caption);
    format!(
        "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n\
         <table{class}>\n<caption>{caption}</caption>\n{rows}</table>\n</div>\n"
    )
}

/// A command to give, on a line of its own.
pub fn command(line: &str) -> String {
    let line = escaped(line);
    format!("<pre tabindex=\"0\" aria-label=\"command\"><code>{line}</code></pre>\n")
}

/// More, for those who want it.
pub fn details(summary: &str, html: &str) -> String {
    format!("<details>\n<summary>{}</summary>\n{html}</details>\n", escaped(summary))
}
