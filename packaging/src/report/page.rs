//! A whole page: head, table of contents, sections, foot. Nothing to fetch, no script.

use std::fmt::Write as _;

use super::html::{Section, escaped};
use super::style::STYLE;

/// The page with this title, what stands above the contents, as HTML, and its sections.
pub fn page(title: &str, lead: &str, sections: &[Section]) -> String {
    let title = escaped(title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#content\">To the content</a>\n<header>\n<h1>{title}</h1>\n{lead}\
         <nav aria-label=\"Contents\">\n<ul>\n"
    );
    for Section { id, title, .. } in sections {
        let _infallible = writeln!(page, "<li><a href=\"#{id}\">{}</a></li>", escaped(title));
    }
    page += "</ul>\n</nav>\n</header>\n<main id=\"content\">\n";
    for Section { id, title, html } in sections {
        let title = escaped(title);
        let _infallible = write!(
            page,
            "<section aria-labelledby=\"{id}\">\n<h2 id=\"{id}\">{title}</h2>\n{html}</section>\n"
        );
    }
    page + "</main>\n</body>\n</html>\n"
}
