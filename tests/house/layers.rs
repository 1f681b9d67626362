//! Imports point one way: a file uses folders before its own in this list, never after; there is no circle among files, nor among
//! what stands in one folder; and no file goes round by what its own folder shows.

use crate::sources::{code, sources};
use std::collections::{BTreeMap, BTreeSet};

/// The folders (and single files) of `src`, lowest first; those of one entry stand on one level.
const LAYERS: [&[&str]; 24] = [
    &["tolerance"],
    &["error", "quantity", "linalg", "observer", "root"],
    &["law"],
    &["model"],
    &["modal"],
    &["impact"],
    &["flow"],
    &["event"],
    &["hybrid"],
    &["path"],
    &["recurrence"],
    &["simulate"],
    &["itinerary"],
    &["orbit"],
    &["continuation"],
    &["section"],
    &["exponents"],
    &["sweep"],
    &["attractor"],
    &["basin"],
    &["branch"],
    &["derivative"],
    &["python"],
    &["lib"],
];

/// Folders in which a circle is known; the list only shrinks.
const CIRCLES: &[&str] = &[];

/// Of each module those that it uses.
type Arrows = BTreeMap<String, BTreeSet<String>>;

fn level(folder: &str) -> usize {
    LAYERS
        .iter()
        .position(|l| l.contains(&folder))
        .unwrap_or_else(|| panic!("{folder} has no place in LAYERS"))
}

/// The code without what it shows of others.
fn without_shown(code: &str) -> String {
    let is_shown = |statement: &&str| {
        let last = statement.trim_start().lines().last().unwrap_or("");
        ["pub use", "pub(crate) use"]
            .iter()
            .any(|shows| statement.trim_start().starts_with(shows) || last.starts_with(shows))
    };
    let statements = code.split_inclusive(';');
    statements
        .filter(|statement| !is_shown(statement))
        .collect()
}

/// The paths that begin with a word: of `crate::a::{b, c::D}` they are `a::b` and `a::c::D`. `$crate`, in a macro, stands for where it
/// is used.
fn paths(code: &str, first: &str) -> Vec<String> {
    let start = format!("{first}::");
    let mut found = Vec::new();
    for (place, _) in code.match_indices(&start) {
        let before = code[..place].chars().next_back().unwrap_or(' ');
        if before.is_alphanumeric() || "_$:".contains(before) {
            continue;
        }
        expand(&code[place + start.len()..], "", &mut found);
    }
    found
}

/// Reads one path, its groups expanded, and returns how much of the text it is.
fn expand(text: &str, prefix: &str, found: &mut Vec<String>) -> usize {
    if !text.starts_with('{') {
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let length = text.find(|c| !is_part(c)).unwrap_or(text.len());
        let path = format!("{prefix}{}", &text[..length]);
        if path.ends_with("::") && text[length..].starts_with('{') {
            return length + expand(&text[length..], &path, found);
        }
        let path = path.trim_end_matches("::self").trim_end_matches("::");
        found.push(path.to_owned());
        return length;
    }
    let mut place = 1;
    while let Some(next) = text[place..].find(|c: char| !c.is_whitespace() && c != ',') {
        place += next;
        if text[place..].starts_with('}') {
            return place + 1;
        }
        place += expand(&text[place..], prefix, found).max(1);
    }
    text.len()
}

/// The modules of the crate.
#[derive(Default)]
struct House {
    /// Of each its code.
    code: BTreeMap<String, String>,
    /// Of each the paths that it uses, from the root.
    used: BTreeMap<String, Vec<String>>,
    /// Those with others in them.
    folders: BTreeSet<String>,
}

impl House {
    fn read() -> Self {
        let mut house = Self::default();
        for (file, text) in sources() {
            house.add(&file, &text);
        }
        house
    }

    fn add(&mut self, file: &str, text: &str) {
        let module = file.trim_end_matches(".rs").replace('/', "::");
        let module = module.trim_end_matches("::mod").to_owned();
        let code = code(text);
        let own = without_shown(&code);
        let mut used = paths(&own, "crate");
        let above = module.rsplit_once("::").map_or("", |(above, _)| above);
        let beside = |path: String| {
            format!("{above}::{path}")
                .trim_start_matches(':')
                .to_owned()
        };
        used.extend(paths(&own, "super").into_iter().map(beside));
        // A file that is more than a list of its folder uses what it shows, too.
        if !file.ends_with("mod.rs") {
            let inner = code.lines().filter_map(|line| line.strip_prefix("mod "));
            let inner = inner.map(|line| line.trim_end_matches(';'));
            let inner = inner.filter(|child| code.contains(&format!("use {child}::")));
            used.extend(inner.map(|child| format!("{module}::{child}")));
        }
        if !above.is_empty() {
            self.folders.insert(above.to_owned());
        }
        self.code.insert(module.clone(), code);
        self.used.insert(module, used);
    }

    /// The longest part of a path that is a module.
    fn module<'p>(&self, path: &'p str) -> Option<&'p str> {
        let mut module = path;
        while !self.code.contains_key(module) {
            module = module.rsplit_once("::")?.0;
        }
        Some(module)
    }

    /// The module that a path leads to, through what folders show of others.
    fn target(&self, path: &str) -> Option<String> {
        let module = self.module(path)?;
        let rest = path[module.len()..].trim_start_matches("::");
        let name = rest.split("::").next().filter(|name| !name.is_empty());
        if let (Some(name), true) = (name, self.folders.contains(module)) {
            let shown = self.shown(module).into_iter();
            let mut same = shown.filter(|path| path.rsplit("::").next() == Some(name));
            if let Some(target) = same.next().and_then(|path| self.target(&path)) {
                return Some(target);
            }
        }
        Some(module.to_owned())
    }

    /// The paths that a folder shows: `pub use course::Leg` in `orbit` is `orbit::course::Leg`.
    fn shown(&self, folder: &str) -> Vec<String> {
        let code = &self.code[folder];
        let mut found = Vec::new();
        for (place, word) in code.match_indices("use ") {
            expand(&code[place + word.len()..], "", &mut found);
        }
        let inside = |path: String| match path.strip_prefix("crate::") {
            Some(path) => path.to_owned(),
            None => format!("{folder}::{path}"),
        };
        found.into_iter().map(inside).collect()
    }

    /// Who uses whom; what a folder's own file holds is `folder::mod`.
    fn arrows(&self) -> Arrows {
        let own = |module: String| {
            if self.folders.contains(&module) {
                module + "::mod"
            } else {
                module
            }
        };
        let mut arrows = Arrows::new();
        for (module, used) in &self.used {
            let from = own(module.clone());
            let used = used.iter().filter_map(|path| self.target(path)).map(own);
            let others = used.filter(|other| *other != from).collect();
            arrows.insert(from, others);
        }
        arrows
    }

    /// Files that use what a folder around them shows of others.
    fn detours(&self) -> BTreeSet<String> {
        let is_detour = |module: &str, path: &str| {
            let Some(folder) = self.module(path) else {
                return false;
            };
            let is_around = module.starts_with(&format!("{folder}::"));
            is_around && self.target(path).as_deref() != Some(folder)
        };
        let mut found = BTreeSet::new();
        for (module, used) in &self.used {
            let round = used.iter().filter(|path| is_detour(module, path));
            found.extend(round.map(|path| format!("{module} by {path}")));
        }
        found
    }
}

/// Arrows among what stands in one folder, for each folder.
fn by_folder(arrows: &Arrows) -> BTreeMap<String, Arrows> {
    let mut all: BTreeMap<String, Arrows> = BTreeMap::new();
    for (from, targets) in arrows {
        let from: Vec<&str> = from.split("::").collect();
        for to in targets {
            let to: Vec<&str> = to.split("::").collect();
            let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if common < from.len() && common < to.len() {
                let graph = all.entry(from[..common].join("::")).or_default();
                let targets = graph.entry(from[common].to_owned()).or_default();
                targets.insert(to[common].to_owned());
            }
        }
    }
    all
}

/// Whether one can be reached from another.
fn is_reached(arrows: &Arrows, from: &str, to: &str) -> bool {
    let (mut open, mut seen) = (vec![from], BTreeSet::new());
    while let Some(here) = open.pop() {
        for next in arrows.get(here).into_iter().flatten() {
            if next == to {
                return true;
            }
            if seen.insert(next.as_str()) {
                open.push(next);
            }
        }
    }
    false
}

/// Those that reach themselves.
fn circle(arrows: &Arrows) -> Vec<&String> {
    let names = arrows.keys();
    names
        .filter(|name| is_reached(arrows, name, name))
        .collect()
}

#[test]
fn imports_point_down() {
    let house = House::read();
    let mut upward = Vec::new();
    for (module, used) in &house.used {
        let own = module.split("::").next().expect("a name");
        for path in used {
            let folder = path.split("::").next().expect("a name");
            if house.code.contains_key(folder) && level(folder) > level(own) {
                upward.push(format!("{module} uses {path}"));
            }
        }
    }
    assert!(upward.is_empty(), "{upward:#?}");
}

#[test]
fn there_is_no_circle() {
    let all = by_folder(&House::read().arrows());
    let circles = all.iter().map(|(folder, graph)| (folder, circle(graph)));
    let circles: BTreeMap<_, _> = circles.filter(|(_, circle)| !circle.is_empty()).collect();
    let folders: Vec<&str> = circles.keys().map(|folder| folder.as_str()).collect();
    assert_eq!(folders, CIRCLES, "{circles:#?}");
}

#[test]
fn nobody_goes_round_by_his_own_folder() {
    let detours = House::read().detours();
    assert!(detours.is_empty(), "{detours:#?}");
}

#[test]
fn what_is_forbidden_would_be_seen() {
    let text = "use crate::orbit::{Pattern, b::{C, d}};\n// crate::python\nfn f() { crate::model::g(); $crate::x::Y }\n";
    let expected = ["orbit::Pattern", "orbit::b::C", "orbit::b::d", "model::g"];
    assert_eq!(paths(&code(text), "crate"), expected);
    assert!(level("orbit") > level("modal"));
    let mut house = House::default();
    house.add("orbit/mod.rs", "mod a;\nmod b;\npub use a::{One, Two};\n");
    house.add("orbit/a.rs", "use crate::orbit::b::Other;\n");
    house.add("orbit/b.rs", "use crate::orbit::Two;\n");
    house.add(
        "steps.rs",
        "mod own;\npub(crate) use own::Own;\nstruct Steps;\n",
    );
    house.add("steps/own.rs", "use super::Steps;\n");
    let graphs = by_folder(&house.arrows());
    assert_eq!(circle(&graphs["orbit"]), ["a", "b"]);
    assert_eq!(circle(&graphs["steps"]), ["mod", "own"]);
    let detours: Vec<_> = house.detours().into_iter().collect();
    assert_eq!(detours, ["orbit::b by orbit::Two"]);
}
