use super::*;
use crate::model::{Figures, Lane, Pool, Task};

/// A page of a run with hostile names.
fn page() -> String {
    let evil = "</script><script>alert(1)</script>";
    let figures = Figures {
        released: 3,
        on_time: 3,
        responses_ns: vec![5, 6, 7],
        response_ns: [Some(6), Some(7), Some(7)],
        ..Figures::default()
    };
    let run = Run {
        policy: "edf".to_owned(),
        tasks: vec![Task { name: evil.to_owned(), deadline_ns: 10, nodes: vec![evil.to_owned()], figures }],
        lanes: vec![Lane { name: evil.to_owned(), pool: 0 }],
        pools: vec![Pool { name: evil.to_owned(), ..Pool::default() }],
        edits: vec![(4, evil.to_owned())],
        certificate: vec![evil.to_owned()],
        end_ns: 9,
        ..Run::default()
    };
    let compared = Compared {
        what: evil.to_owned(),
        values: vec![(evil.to_owned(), 1.0), ("b".to_owned(), 0.0)],
        ..Compared::default()
    };
    let head = Head { title: evil.to_owned(), data: format!("{{\"name\":\"{evil}\"}}"), ..Head::default() };
    of_runs(&head, &[run.clone(), run], &[compared])
}

/// Every element that is opened is closed in its turn; what scripts and styles hold is text.
fn well_formed(page: &str) -> Result<(), String> {
    let (mut open, mut rest) = (Vec::new(), page);
    while let Some((_, after)) = rest.split_once('<') {
        let (tag, next) = after.split_once('>').ok_or("a tag without an end")?;
        rest = next;
        let name = tag.split([' ', '\n']).next().unwrap_or_default();
        if let Some(name) = name.strip_prefix('/') {
            let last = open.pop().ok_or(format!("</{name}> closes nothing"))?;
            if last != name {
                return Err(format!("</{name}> closes <{last}>"));
            }
        } else if !name.starts_with('!') && !tag.ends_with('/') {
            open.push(name.to_owned());
            if matches!(name, "script" | "style") {
                let end = rest.find(&format!("</{name}>")).ok_or("a script without an end")?;
                rest = &rest[end..];
            }
        }
    }
    if open.is_empty() { Ok(()) } else { Err(format!("open at the end: {open:?}")) }
}

#[test]
fn the_page_is_well_formed_whatever_names_say() {
    let page = page();
    assert_eq!(well_formed(&page), Ok(()));
    assert!(!page.contains("alert(1)</script><script>") && !page.contains("<script>alert"), "{page}");
}

#[test]
fn a_page_with_an_open_element_is_found_out() {
    assert!(well_formed(&page().replacen("</section>", "", 1)).is_err());
    assert!(well_formed(&page().replacen("<main>", "", 1)).is_err());
}

#[test]
fn the_page_needs_nothing_else() {
    let page = page();
    for reference in ["http:", "https:", "//cdn", "src=", "@import", "url(", "<link", "fetch(", "XMLHttp"] {
        assert!(!page.contains(reference), "{reference}");
    }
}
