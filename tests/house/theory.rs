//! What comments cite as theory is a section of `docs/theory.md`, and no citation points outside the repository.

use crate::sources::collect;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Folders whose comments are read; a package has fewer.
const FOLDERS: [&str; 5] = ["src", "tests", "python", "examples", "benches"];
/// A section, and the name in quotes that may follow its number.
#[derive(Debug, PartialEq, Eq)]
struct Citation {
    section: u32,
    name: Option<String>,
}

fn citation(section: u32) -> Citation {
    Citation {
        section,
        name: None,
    }
}

/// The words of a text; the marks at the head of a comment's lines are none.
fn words(text: &str) -> Vec<&str> {
    let is_mark = |word: &&str| ["//", "///", "//!", "#"].contains(word);
    text.split_whitespace()
        .filter(|word| !is_mark(word))
        .collect()
}

/// The number that a word begins with, if only punctuation follows it.
fn number(word: &str) -> Option<u32> {
    let end = word.find(|c: char| !c.is_ascii_digit());
    let (digits, rest) = word.split_at(end.unwrap_or(word.len()));
    let is_whole = !rest.starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '-');
    let is_decimal = rest.chars().nth(1).is_some_and(|c| c.is_ascii_digit());
    digits.parse().ok().filter(|_| is_whole && !is_decimal)
}

/// What stands in quotes at the start of some words.
fn quoted(words: &[&str]) -> Option<String> {
    let text = words.iter().take(12).copied().collect::<Vec<_>>().join(" ");
    let inside = text.strip_prefix('"')?;
    inside.split_once('"').map(|(name, _)| name.to_owned())
}

/// Every citation in a text: `theory 5, 6 and 7`, `theory section 5`, `theory 5, "a name"`.
fn citations(text: &str) -> Vec<Citation> {
    let words = words(text);
    let mut found = Vec::new();
    for (i, word) in words.iter().enumerate() {
        let bare = word.trim_start_matches(|c: char| !c.is_alphanumeric());
        if !bare.eq_ignore_ascii_case("theory") {
            continue;
        }
        let mut at = i + 1;
        if words.get(at).is_some_and(|w| w.starts_with("section")) {
            at += 1;
        }
        while let Some(section) = words.get(at).and_then(|word| number(word)) {
            found.push(citation(section));
            let goes_on = words[at].ends_with(',');
            at += 1;
            if let (true, Some(last)) = (goes_on, found.last_mut()) {
                last.name = quoted(&words[at..]);
            }
            let is_joined = words.get(at).is_some_and(|word| *word == "and");
            if is_joined {
                at += 1;
            } else if !goes_on {
                break;
            }
        }
    }
    found
}

/// The texts that are named and are not in the repository: of `docs/theory.md` the word, less its punctuation.
fn strangers(text: &str, is_there: impl Fn(&str) -> bool) -> Vec<&str> {
    let is_part = |c: char| c.is_alphanumeric() || "_-./".contains(c);
    let names = text.split(|c| !is_part(c));
    let names = names.map(|name| name.trim_end_matches('.'));
    names
        .filter(|name| Path::new(name).extension().is_some_and(|e| e == "md") && !is_there(name))
        .collect()
}

/// The sections of the document by number.
fn sections(document: &str) -> BTreeMap<u32, String> {
    let mut found = BTreeMap::new();
    let mut current = None;
    for line in document.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            let (head, _) = title.split_once(". ").unwrap_or((title, ""));
            current = head.parse().ok();
            if let Some(section) = current {
                let known = found.insert(section, String::new());
                assert!(known.is_none(), "section {section} stands twice");
            }
        }
        if let Some(text) = current.and_then(|section| found.get_mut(&section)) {
            text.push_str(line);
            text.push('\n');
        }
    }
    found
}

/// Whether a citation finds what it cites.
fn is_found(sections: &BTreeMap<u32, String>, cited: &Citation) -> bool {
    let Some(text) = sections.get(&cited.section) else {
        return false;
    };
    let Some(name) = &cited.name else {
        return true;
    };
    text.to_lowercase()
        .contains(&format!("**{}", name.to_lowercase()))
}

#[test]
fn every_section_cited_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let document = fs::read_to_string(root.join("docs/theory.md")).expect("it is there");
    let sections = sections(&document);
    let mut all = Vec::new();
    for folder in FOLDERS {
        collect(&root.join(folder), &["rs", "py", "pyi"], &mut all);
    }
    all.retain(|file| !file.ends_with("tests/house/theory.rs"));
    let (mut count, mut wrong) = (0, Vec::new());
    for file in all {
        let text = fs::read_to_string(&file).expect("readable");
        let name = file.strip_prefix(root).expect("below the root").display();
        for cited in citations(&text) {
            count += 1;
            if !is_found(&sections, &cited) {
                wrong.push(format!("{name} cites {cited:?}"));
            }
        }
        let is_there = |name: &str| {
            let mut places = ["", "docs", "docs/report"].into_iter();
            places.any(|place| root.join(place).join(name).exists())
        };
        let strange = strangers(&text, is_there);
        wrong.extend(strange.iter().map(|word| format!("{name} names {word}")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 80, "{count}");
}

#[test]
fn sections_are_numbered_in_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let document = fs::read_to_string(root.join("docs/theory.md")).expect("it is there");
    let heads: Vec<u32> = sections(&document).into_keys().collect();
    let last = u32::try_from(heads.len()).expect("few");
    assert_eq!(heads, (1..=last).collect::<Vec<_>>());
}

#[test]
fn citations_are_read_as_they_are_written() {
    let numbers = |text: &str| -> Vec<u32> { citations(text).iter().map(|c| c.section).collect() };
    assert_eq!(numbers("//! Flights (theory 8).\n"), [8]);
    assert_eq!(numbers("Theory sections 8 and 9; J. R. Dormand"), [8, 9]);
    assert_eq!(numbers("(theory 5, 6, 7). Arrays"), [5, 6, 7]);
    assert_eq!(numbers("theory 8, most of them 2.5"), [8]);
    assert_eq!(numbers("// theory 1: 5.27 for m = 1"), [1]);
    assert_eq!(numbers("of the theory\n/// 4 and 5, as"), [4, 5]);
    assert_eq!(numbers("the answers that theory gives, 1 or 2"), []);
    let named = citations("theory 5, \"several\n//! instants\", as");
    assert_eq!(named[0].name.as_deref(), Some("several instants"));
}

#[test]
fn a_wrong_citation_would_be_seen() {
    let document = "# Theory\n\n## 1. Gaps\n\n**One name.** Text.\n\n## 2. More\n\n## References\n";
    let sections = sections(document);
    assert_eq!(sections.keys().copied().collect::<Vec<_>>(), [1, 2]);
    let is_right = |text: &str| citations(text).iter().all(|c| is_found(&sections, c));
    assert!(is_right("(theory 1 and 2), theory 1, \"one name\""));
    assert!(!is_right("(theory 3)"));
    assert!(!is_right("theory 1, 2, 12"));
    assert!(!is_right("theory 2, \"one name\""));
    let is_there = |name: &str| name == "docs/theory.md";
    assert_eq!(
        strangers("see docs/theory.md, (notes.md) and theory.md.", is_there),
        ["notes.md", "theory.md"]
    );
}
