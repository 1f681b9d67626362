//! A name lives once and is a word of the field; a number that decides an outcome stands in `src/tolerance.rs`.

use crate::sources::{sources, without_tests};
use std::collections::{BTreeMap, BTreeSet};

/// Words that are in no textbook's index, as whole words of names.
const PRIVATE_WORDS: [&str; 25] = [
    "abreast", "behind", "cell", "course", "effort", "flown", "followed", "foot", "gone", "landed",
    "leg", "lessened", "looked", "looks", "missed", "moving", "nearly", "retained", "risen",
    "seen", "spot", "tip", "vanished", "watch", "way",
];

/// What a declaration declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Type,
    Trait,
    Function,
    Constant,
    Field,
    Variant,
}

/// A declared name, whether it is seen outside its file, the indentation of its line, the text behind the name, and the documentation
/// above it.
struct Declared {
    kind: Kind,
    name: String,
    is_shown: bool,
    indent: usize,
    rest: String,
    docs: String,
}

/// The identifier that a text begins with.
fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// A line without its visibility and qualifiers.
fn unqualified(line: &str) -> &str {
    let mut line = line;
    loop {
        let before = line;
        if let Some(rest) = line.strip_prefix("pub(") {
            line = rest
                .split_once(')')
                .map_or(rest, |(_, rest)| rest)
                .trim_start();
        }
        for word in ["pub ", "unsafe ", "async ", "extern \"C\" "] {
            line = line.strip_prefix(word).unwrap_or(line);
        }
        if line.starts_with("const fn ") {
            line = &line["const ".len()..];
        }
        if line == before {
            return line;
        }
    }
}

/// The names that a file declares, its tests left out. Formatted code has one declaration in a line.
fn declared(text: &str) -> Vec<Declared> {
    let (mut found, mut docs) = (Vec::new(), String::new());
    // The indentation of the declarations inside, and whether they are variants, of each type whose body is open.
    let mut open: Vec<(usize, bool)> = Vec::new();
    for line in without_tests(text).lines() {
        let trimmed = line.trim_start();
        let indent = line.len() - trimmed.len();
        if let Some(doc) = trimmed.strip_prefix("///") {
            docs.push_str(doc);
            continue;
        }
        if trimmed.is_empty() || trimmed.starts_with("//") || trimmed.starts_with("#[") {
            continue;
        }
        if trimmed.starts_with('}') {
            open.retain(|(inside, _)| *inside <= indent);
        }
        let code = unqualified(trimmed);
        let declare = |kind, (name, rest): (&str, &str)| Declared {
            kind,
            name: name.to_owned(),
            is_shown: trimmed.starts_with("pub"),
            indent,
            rest: rest.to_owned(),
            docs: docs.clone(),
        };
        let kinds = [
            ("struct ", Kind::Type),
            ("enum ", Kind::Type),
            ("union ", Kind::Type),
            ("type ", Kind::Type),
            ("trait ", Kind::Trait),
            ("fn ", Kind::Function),
            ("const ", Kind::Constant),
            ("static ", Kind::Constant),
        ];
        let item = kinds
            .iter()
            .find_map(|&(word, kind)| Some((code.strip_prefix(word)?, kind, word)));
        if let Some((rest, kind, word)) = item {
            let name = identifier(rest);
            if !name.is_empty() {
                found.push(declare(kind, rest.split_at(name.len())));
            }
            if ["struct ", "enum "].contains(&word) && line.ends_with('{') {
                open.push((indent + 4, word == "enum "));
            }
        } else if let Some(&(_, is_enum)) = open.iter().find(|(inside, _)| *inside == indent) {
            let name = identifier(code);
            let rest = &code[name.len()..];
            let kind = if is_enum { Kind::Variant } else { Kind::Field };
            if !name.is_empty() && (is_enum || rest.starts_with(':')) {
                found.push(declare(kind, (name, rest)));
                if is_enum && line.ends_with('{') {
                    open.push((indent + 4, false));
                }
                // A variant with its fields in one line.
                let inside = rest
                    .split_once("{ ")
                    .and_then(|(_, all)| all.split_once(" }"));
                let fields = inside.into_iter().flat_map(|(all, _)| all.split(", "));
                let fields = fields.filter_map(|field| field.split_once(": "));
                found.extend(fields.map(|field| declare(Kind::Field, field)));
            }
        }
        docs.clear();
    }
    found
}

/// The words of a name in one case.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for c in name.chars() {
        if c == '_' || (c.is_uppercase() && was_lower) {
            words.push(String::new());
        }
        was_lower = c.is_lowercase() || c.is_numeric();
        if c != '_' {
            words
                .last_mut()
                .expect("one at least")
                .extend(c.to_lowercase());
        }
    }
    words
}

/// Where each name of a kind is declared at the top of a file.
fn places(files: &[(String, String)], kinds: &[Kind]) -> BTreeMap<String, BTreeSet<String>> {
    let mut places: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in files {
        for own in declared(text) {
            if own.indent == 0 && kinds.contains(&own.kind) {
                places.entry(own.name).or_default().insert(path.clone());
            }
        }
    }
    places
}

/// Types that stand in two files; a class of the bindings has the name of what it shows.
fn doubled(files: &[(String, String)]) -> Vec<String> {
    let is_core = |path: &&String| !path.starts_with("python/");
    let places = places(files, &[Kind::Type, Kind::Trait]).into_iter();
    let twice = places.filter(|(_, at)| at.iter().filter(is_core).count() > 1);
    twice.map(|(name, at)| format!("{name}: {at:?}")).collect()
}

#[test]
fn a_type_has_a_name_of_its_own() {
    let doubled = doubled(&sources());
    assert!(
        doubled.is_empty(),
        "{} names stand twice:\n{}",
        doubled.len(),
        doubled.join("\n")
    );
}

/// Names with a word of no textbook, those of files among them.
fn private(files: &[(String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in files {
        let module = path.trim_end_matches(".rs").rsplit('/').next();
        let names = declared(text).into_iter().map(|own| own.name);
        for name in names.chain(module.map(str::to_owned)) {
            if (words(&name).iter()).any(|word| PRIVATE_WORDS.contains(&word.as_str())) {
                found.push(format!("{name} ({path})"));
            }
        }
    }
    found
}

#[test]
fn names_are_words_of_the_field() {
    let found = private(&sources());
    assert!(
        found.is_empty(),
        "{} names are of no textbook:\n{}",
        found.len(),
        found.join("\n")
    );
}

/// The number that a constant is, if it is one.
fn is_number(own: &Declared) -> bool {
    let of = own.rest.trim_start_matches(':').trim_start();
    let of = of.trim_start_matches('[');
    ["f64", "usize", "u32", "u64", "i32", "i64", "u8"]
        .iter()
        .any(|kind| identifier(of) == *kind)
}

/// Constants outside `tolerance.rs` that do not say why they decide nothing.
fn unmarked(files: &[(String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in files.iter().filter(|(path, _)| path != "tolerance.rs") {
        for own in declared(text) {
            let is_marked = ["[work]", "[exact]"]
                .iter()
                .any(|mark| own.docs.contains(mark));
            if own.kind == Kind::Constant && is_number(&own) && !is_marked {
                found.push(format!("{} ({path})", own.name));
            }
        }
    }
    found
}

#[test]
fn what_decides_an_outcome_stands_among_the_tolerances() {
    let found = unmarked(&sources());
    assert!(
        found.is_empty(),
        "{} constants decide elsewhere:\n{}",
        found.len(),
        found.join("\n")
    );
}

/// Numbers with an exponent that are no constants.
fn nameless(files: &[(String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in files {
        let mut is_constant = false;
        for line in without_tests(text).lines() {
            let code = line.split("//").next().unwrap_or_default();
            let own = unqualified(code.trim_start());
            is_constant |= own.starts_with("const ") || own.starts_with("static ");
            let plain: String = code.split('"').step_by(2).collect();
            if !is_constant && !own.starts_with("#[") && has_exponent(&plain) {
                found.push(format!("{} ({path})", code.trim()));
            }
            is_constant &= !code.trim_end().ends_with(';');
        }
    }
    found
}

/// Whether a text has a number with an exponent, as `1e-9`.
fn has_exponent(text: &str) -> bool {
    let bytes = text.as_bytes();
    let is_part = |at: usize| bytes[at].is_ascii_digit() || bytes[at] == b'.';
    (1..bytes.len()).filter(|&at| bytes[at] == b'e').any(|at| {
        let digits = (0..at).rev().take_while(|&k| is_part(k)).count();
        let is_name = digits < at
            && bytes[..at - digits]
                .last()
                .is_some_and(u8::is_ascii_alphanumeric);
        let next = bytes.get(at + 1);
        digits > 0 && !is_name && next.is_some_and(|c| *c == b'-' || c.is_ascii_digit())
    })
}

#[test]
fn a_threshold_has_a_name() {
    let found = nameless(&sources());
    assert!(
        found.is_empty(),
        "{} numbers have no name:\n{}",
        found.len(),
        found.join("\n")
    );
}

/// Names of constants with several values.
fn ambiguous(files: &[(String, String)]) -> Vec<String> {
    let mut values: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for own in files.iter().flat_map(|(_, text)| declared(text)) {
        let is_free = own.kind == Kind::Constant && own.indent == 0;
        if let Some((_, value)) = own.rest.split_once(" = ").filter(|_| is_free) {
            values.entry(own.name).or_default().insert(value.to_owned());
        }
    }
    let twice = values.into_iter().filter(|(_, values)| values.len() > 1);
    twice
        .map(|(name, values)| format!("{name}: {values:?}"))
        .collect()
}

#[test]
fn a_constant_has_one_value() {
    let found = ambiguous(&sources());
    assert!(
        found.is_empty(),
        "{} names have several values:\n{}",
        found.len(),
        found.join("\n")
    );
}

/// Public arrays whose documentation says neither a shape nor a unit.
fn shapeless(files: &[(String, String)]) -> Vec<String> {
    let mut found = Vec::new();
    let arrays = ["DVector<", "DMatrix<", "Vec<f64>", "Vec<Vec<f64>>", "Array"];
    for (path, text) in files {
        for own in declared(text)
            .into_iter()
            .filter(|own| own.kind == Kind::Field && own.is_shown)
        {
            let is_array = arrays.iter().any(|array| own.rest.contains(array));
            let says = own.docs.contains("shape") && own.docs.contains('[');
            if is_array && !says {
                found.push(format!("{} ({path})", own.name));
            }
        }
    }
    found
}

#[test]
fn an_array_has_a_shape_and_a_unit() {
    let found = shapeless(&sources());
    assert!(
        found.is_empty(),
        "{} arrays have no shape and unit:\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn what_is_forbidden_would_be_seen() {
    let file = |path: &str, text: &str| (path.to_owned(), text.to_owned());
    let files = [
        file(
            "a.rs",
            "/// One.\npub struct Twice {\n    pub q: DVector<f64>,\n    v: DVector<f64>,\n}\n\n/// Odd.\nconst SIZE: f64 = 1.0;\n",
        ),
        file(
            "b/leg.rs",
            "enum Twice {\n    WayOut,\n    Watched { spot: f64 },\n}\n\n/// A bound. [work]\nconst SIZE: f64 = 2.0;\n",
        ),
        file(
            "python/c.rs",
            "struct Twice;\n\n#[cfg(test)]\nmod tests {\n    struct Leg;\n}\n",
        ),
        file(
            "tolerance.rs",
            "/// Fine.\npub(crate) const OTHER: f64 = 1.0;\n",
        ),
    ];
    let [one, other] = ["a.rs", "b/leg.rs"];
    assert_eq!(
        doubled(&files),
        [format!(
            "Twice: {:?}",
            BTreeSet::from([one, other, "python/c.rs"])
        )]
    );
    assert_eq!(
        private(&files),
        ["WayOut (b/leg.rs)", "spot (b/leg.rs)", "leg (b/leg.rs)"]
    );
    assert_eq!(unmarked(&files), ["SIZE (a.rs)"]);
    assert_eq!(ambiguous(&files), ["SIZE: {\"1.0;\", \"2.0;\"}"]);
    assert_eq!(shapeless(&files), ["q (a.rs)"]);
    let files = [file(
        "d.rs",
        "const SMALL: [f64; 1] = [\n    1e-3,\n];\nfn f(x1e3: f64) -> bool {\n    x1e3 < 2.5e-4 // 1e-9\n}\n",
    )];
    assert_eq!(nameless(&files), ["x1e3 < 2.5e-4 (d.rs)"]);
}
