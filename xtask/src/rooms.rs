//! `cargo xtask rooms`: who leans on whom. Fails on files that import each other in a circle, on an import that climbs
//! against the order of rooms in `xtask/rooms.txt`, and on a package that has outgrown its lines there.
//!
//! Read as text: `use` declarations and paths that begin with `crate`, `super`, `self` or the package's own name, followed
//! through re-exports to the file that they come from. Tests inside files do not count. What it cannot see: an import that a
//! macro writes, and methods called without naming their type.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::run::{self, Failure, read};

/// Order and size of the rooms, under review.
const FILE: &str = "xtask/rooms.txt";

/// Prints every package's lines, circles and climbing imports; any that is not allowed is a failure. `root` is the
/// repository to look at, this one unless another is named.
pub(crate) fn rooms(root: &Path) -> Result<(), Failure> {
    let allowed = Allowed::read(&run::root().join(FILE))?;
    let mut wrong = Vec::new();
    let mut total = 0;
    println!("{:<24} {:>7} {:>7}  circles", "package", "lines", "at most");
    for (folder, allowed) in &allowed {
        if !root.join(folder).join("Cargo.toml").exists() {
            continue;
        }
        let package = Package::read(&root.join(folder))?;
        let circles = package.circles();
        total += package.lines;
        println!("{folder:<24} {:>7} {:>7}  {}", package.lines, allowed.lines, circles.len());
        if package.lines > allowed.lines {
            wrong.push(format!("{folder} has {} lines, {FILE} allows {}", package.lines, allowed.lines));
        }
        for circle in &circles {
            wrong.push(format!("{folder}: {} files import each other: {}", circle.len(), circle.join(", ")));
        }
        wrong.extend(package.climbs(&allowed.order).into_iter().map(|climb| format!("{folder}: {climb}")));
    }
    println!("{:<24} {total:>7}", "all");
    for line in &wrong {
        eprintln!("    {line}");
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(Failure::new(format!("{} imports or sizes are not as {FILE} says", wrong.len())))
    }
}

/// What a package may be.
struct Allowed {
    lines: usize,
    /// Rooms from the top down, each level a list.
    order: Vec<Vec<String>>,
}

impl Allowed {
    /// `folder lines room room | room | …`, a line each; `#` begins a comment.
    fn read(file: &Path) -> Result<BTreeMap<String, Self>, Failure> {
        let text = read(file)?;
        let mut found = BTreeMap::new();
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty()) {
            let wrong = || Failure::new(format!("{FILE}: `{line}` is not `folder lines room room | room …`"));
            let (folder, rest) = line.split_once(' ').ok_or_else(wrong)?;
            let (lines, order) = rest.trim().split_once(' ').unwrap_or((rest.trim(), ""));
            let lines = lines.parse().map_err(|_| wrong())?;
            let words = |level: &str| level.split_whitespace().map(str::to_owned).collect();
            found.insert(folder.to_owned(), Self { lines, order: order.split('|').map(words).collect() });
        }
        Ok(found)
    }
}

/// One package: its modules, and what each of its files imports of the others.
struct Package {
    lines: usize,
    /// Files by name, with the files that they import.
    imports: BTreeMap<String, BTreeSet<String>>,
}

/// A file with its place among the modules.
struct File {
    module: Vec<String>,
    code: String,
}

impl Package {
    fn read(folder: &Path) -> Result<Self, Failure> {
        let name = package_name(folder)?;
        let mut paths = Vec::new();
        collect(&folder.join("src"), &mut paths);
        collect(&folder.join("benches"), &mut paths);
        let mut lines = 0;
        let mut files = BTreeMap::new();
        for path in &paths {
            let text = read(path)?;
            lines += text.lines().count();
            // Benches count, but nobody imports them.
            let Ok(relative) = path.strip_prefix(folder.join("src")) else { continue };
            let file = relative.to_string_lossy().into_owned();
            files.insert(file, File { module: module_of(relative), code: without_tests(&without_comments(&text)) });
        }
        let modules = Modules::new(&files, name);
        let imports = files
            .iter()
            .map(|(name, file)| {
                let mut seen: BTreeSet<String> =
                    paths_in(&file.code).iter().filter_map(|path| modules.resolve(&file.module, path, 0)).collect();
                seen.remove(name);
                (name.clone(), seen)
            })
            .collect();
        Ok(Self { lines, imports })
    }

    /// Sets of files each of which can be reached from every other (Tarjan's would be quicker; this is 300 files).
    fn circles(&self) -> Vec<Vec<String>> {
        let reach: BTreeMap<&str, BTreeSet<&str>> =
            self.imports.keys().map(|file| (file.as_str(), self.reached(file))).collect();
        let mut seen = BTreeSet::new();
        let mut circles = Vec::new();
        for (file, far) in &reach {
            if far.contains(file) && !seen.contains(file) {
                let back = |other: &&&str| reach.get(**other).is_some_and(|back| back.contains(file));
                let circle: Vec<&str> = far.iter().filter(back).copied().collect();
                seen.extend(circle.iter().copied());
                circles.push(circle.into_iter().map(str::to_owned).collect());
            }
        }
        circles
    }

    fn reached<'a>(&'a self, from: &'a str) -> BTreeSet<&'a str> {
        let mut open = vec![from];
        let mut found = BTreeSet::new();
        while let Some(file) = open.pop() {
            for next in self.imports.get(file).into_iter().flatten() {
                if found.insert(next.as_str()) {
                    open.push(next);
                }
            }
        }
        found
    }

    /// Imports of a room that stands above the importing one, or of a room that is in no order.
    fn climbs(&self, order: &[Vec<String>]) -> Vec<String> {
        let level = |file: &str| {
            let room = file.split('/').next().unwrap_or(file).trim_end_matches(".rs").to_owned();
            order.iter().position(|rooms| rooms.contains(&room))
        };
        let mut climbs = Vec::new();
        // The root only names its rooms; a package may have no order.
        let ordered = |file: &str| !matches!(file, "lib.rs" | "main.rs") && !order.iter().all(Vec::is_empty);
        for (file, seen) in self.imports.iter().filter(|(file, _)| ordered(file)) {
            climbs.extend(seen.iter().filter_map(|other| match (level(file), level(other)) {
                (Some(from), Some(to)) if to < from => Some(format!("{file} climbs to {other}")),
                (None, _) => Some(format!("{file} is in no room of {FILE}")),
                _ => None,
            }));
        }
        climbs.dedup();
        climbs
    }
}

/// The modules of a package and what they pass on.
struct Modules {
    name: String,
    /// File of every module.
    files: BTreeMap<Vec<String>, String>,
    /// Of every module: name that it re-exports, and the path from there; `*` for all.
    passed: BTreeMap<Vec<String>, Vec<(String, Vec<String>)>>,
    /// Of every file: names that it defines.
    defined: BTreeMap<String, BTreeSet<String>>,
}

impl Modules {
    fn new(files: &BTreeMap<String, File>, name: String) -> Self {
        let mut modules = Self { name, files: BTreeMap::new(), passed: BTreeMap::new(), defined: BTreeMap::new() };
        for (name, file) in files {
            // Where a package has both, the library is what its program imports.
            if name != "main.rs" || !files.contains_key("lib.rs") {
                modules.files.insert(file.module.clone(), name.clone());
            }
            modules.defined.insert(name.clone(), defined(&file.code));
            let passed = uses(&file.code).into_iter().filter(|(public, _)| *public);
            let passed = passed.filter_map(|(_, path)| Some((path.last()?.clone(), path)));
            modules.passed.insert(file.module.clone(), passed.collect());
        }
        modules
    }

    /// The file that the path leads to, seen from `module`; none if it leads out of the package.
    fn resolve(&self, module: &[String], path: &[String], depth: usize) -> Option<String> {
        let mut here: Vec<String> = module.to_vec();
        let (first, mut rest) = path.split_first()?;
        match first.as_str() {
            "self" => {}
            "super" => drop(here.pop()),
            first if first == "crate" || first == self.name => here.clear(),
            first => {
                here.push(first.to_owned());
                self.files.get(&here)?;
            }
        }
        while let Some(after) = rest.strip_prefix(&["super".to_owned()]) {
            here.pop();
            rest = after;
        }
        while let Some((next, after)) = rest.split_first() {
            here.push(next.clone());
            if self.files.contains_key(&here) {
                rest = after;
                continue;
            }
            here.pop();
            if depth < 8 {
                for (name, target) in self.passed.get(&here).into_iter().flatten() {
                    if name == next {
                        return self.resolve(&here, target, depth + 1).or_else(|| self.files.get(&here).cloned());
                    }
                    if name == "*"
                        && let Some(file) = self.resolve(&here, &target[..target.len() - 1], depth + 1)
                        && self.defined.get(&file).is_some_and(|names| names.contains(next))
                    {
                        return Some(file);
                    }
                }
            }
            break;
        }
        self.files.get(&here).cloned()
    }
}

/// The name under which a package's own program imports its library.
fn package_name(folder: &Path) -> Result<String, Failure> {
    let manifest = read(&folder.join("Cargo.toml"))?;
    let library = manifest.split("[lib]").nth(1).and_then(|text| text.split("name = \"").nth(1));
    let name = library.or_else(|| manifest.split("name = \"").nth(1)).and_then(|text| text.split('"').next());
    Ok(name.unwrap_or_default().replace('-', "_"))
}

fn module_of(file: &Path) -> Vec<String> {
    let mut module: Vec<String> =
        file.iter().map(|part| part.to_string_lossy().trim_end_matches(".rs").to_owned()).collect();
    if module.last().is_some_and(|last| matches!(last.as_str(), "mod" | "lib" | "main")) {
        module.pop();
    }
    module
}

/// Every path that begins inside the package, `use` trees taken apart.
fn paths_in(code: &str) -> Vec<Vec<String>> {
    let mut paths: Vec<Vec<String>> = uses(code).into_iter().map(|(_, path)| path).collect();
    let mut rest = code;
    while let Some(at) = ["crate::", "super::"].iter().filter_map(|start| rest.find(start)).min() {
        let before = rest[..at].chars().next_back();
        let path: String =
            rest[at..].chars().take_while(|sign| sign.is_alphanumeric() || *sign == '_' || *sign == ':').collect();
        rest = &rest[at + path.len().max(1)..];
        if before.is_none_or(|sign| !(sign.is_alphanumeric() || sign == '_' || sign == '$' || sign == ':')) {
            paths.push(path.split("::").filter(|word| !word.is_empty()).map(str::to_owned).collect());
        }
    }
    paths
}

/// The declarations `use` and `pub use`, a path for each name, with whether it is passed on.
fn uses(code: &str) -> Vec<(bool, Vec<String>)> {
    let mut found = Vec::new();
    for statement in code.split(';') {
        let Some(at) = find_use(statement) else { continue };
        let public = statement[..at].trim_end().ends_with("pub") || statement[..at].trim_end().ends_with(')');
        take_apart(statement[at + 4..].trim(), &[], &mut |path| found.push((public, path)));
    }
    found
}

fn find_use(statement: &str) -> Option<usize> {
    let alone = |at: &usize| statement[..*at].chars().next_back().is_none_or(char::is_whitespace);
    statement.match_indices("use ").map(|(at, _)| at).find(alone)
}

fn take_apart(tree: &str, before: &[String], each: &mut impl FnMut(Vec<String>)) {
    let with = |path: &str| -> Vec<String> {
        let words = path.split("::").map(|word| word.split(" as ").next().unwrap_or(word).trim());
        before.iter().cloned().chain(words.filter(|word| !word.is_empty()).map(str::to_owned)).collect()
    };
    match tree.split_once('{') {
        None if tree.trim() == "self" => each(before.to_vec()),
        None => each(with(tree)),
        Some((path, inside)) => {
            let before = with(path.trim().trim_end_matches("::"));
            let inside = inside.trim_end().strip_suffix('}').unwrap_or(inside);
            let (mut depth, mut start) = (0, 0);
            for (at, sign) in inside.char_indices().chain([(inside.len(), ',')]) {
                match sign {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        let one = inside[start..at].trim();
                        if !one.is_empty() {
                            take_apart(one, &before, each);
                        }
                        start = at + 1;
                    }
                    _ => {}
                }
            }
        }
    }
}

/// Names of what a file defines, wherever it stands.
fn defined(code: &str) -> BTreeSet<String> {
    let words: Vec<&str> =
        code.split(|sign: char| !(sign.is_alphanumeric() || sign == '_')).filter(|word| !word.is_empty()).collect();
    let kinds = ["fn", "struct", "enum", "trait", "const", "static", "type", "mod", "union"];
    words.windows(2).filter(|pair| kinds.contains(&pair[0])).map(|pair| pair[1].to_owned()).collect()
}

/// The code without comments and texts.
fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    for line in text.lines() {
        let (mut inside, mut before) = (false, ' ');
        let mut signs = line.chars().peekable();
        while let Some(sign) = signs.next() {
            match sign {
                '"' if before != '\\' && before != '\'' => inside = !inside,
                '/' if !inside && signs.peek() == Some(&'/') => break,
                _ if inside => {}
                _ => code.push(sign),
            }
            before = if before == '\\' { ' ' } else { sign };
        }
        code.push('\n');
    }
    code
}

/// The code without modules that only tests have.
fn without_tests(code: &str) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(test)]") {
        kept += &rest[..at];
        rest = &rest[at..];
        let end = match (rest.find('{'), rest.find(';')) {
            (Some(open), semicolon) if semicolon.is_none_or(|semicolon| open < semicolon) => {
                let mut depth = 0;
                rest[open..]
                    .char_indices()
                    .find(|(_, sign)| {
                        depth += i32::from(*sign == '{') - i32::from(*sign == '}');
                        depth == 0
                    })
                    .map_or(rest.len(), |(close, _)| open + close + 1)
            }
            (_, Some(semicolon)) => semicolon + 1,
            _ => rest.len(),
        };
        rest = &rest[end..];
    }
    kept + rest
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/rooms.rs"]
mod tests;
