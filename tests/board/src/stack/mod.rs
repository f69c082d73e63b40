//! Static stack: the deepest path from an entry, as the image's own instructions have it.
//!
//! A function's frame is all that it ever takes ([`thumb`]); its callees come on top, those that it jumps to as well. What calls
//! through a pointer reaches what the reviewed list `calls.txt` says, and nothing is said of what is not on it. So a path is
//! never too shallow, and may be deeper than any that is ever taken.
//!
//! The one stack holds thread mode, every interrupt once (none preempts itself, nor one of its own priority), and for each
//! the registers that the processor puts there.

pub mod code;
pub mod thumb;

use std::collections::BTreeMap;
use std::fmt;

use code::{Code, veneer};
use cohold_cli::Failure;

const LIST: &str = include_str!("../../calls.txt");
/// What the processor puts on the stack at an interrupt, with the FPU in use and the stack aligned to 8 bytes.
pub const EXCEPTION_FRAME: u64 = 26 * 4 + 4;

/// The deepest way down from an entry.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// Depth of the stack, bytes.
    pub bytes: u64,
    /// Functions on the way, and the frame of each.
    pub steps: Vec<(u64, String)>,
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} bytes:", self.bytes)?;
        self.steps.iter().try_for_each(|(bytes, name)| writeln!(f, "{bytes:>8}  {name}"))
    }
}

/// A line of the reviewed list.
#[derive(Debug)]
enum Line<'a> {
    /// Functions called so call, through pointers, functions called so.
    Calls(Vec<&'a str>, Vec<&'a str>),
    /// A function called so stands on the stack at most so many times.
    AtMost(&'a str, u32),
}

/// The lines of the list: `CALLER | CALLER -> CALLEE | CALLEE` or `FUNCTION <= TIMES`, two spaces or more, and the reason.
fn list(text: &str) -> Vec<Line<'_>> {
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty());
    lines
        .map(|line| {
            let parts = line.split_once("  ").filter(|(_, reason)| !reason.trim().is_empty());
            let (rule, _) = parts.unwrap_or_else(|| panic!("calls.txt: no reason in {line:?}"));
            if let Some((callers, callees)) = rule.split_once(" -> ") {
                Line::Calls(callers.split(" | ").collect(), callees.split(" | ").collect())
            } else if let Some((function, times)) = rule.split_once(" <= ") {
                Line::AtMost(function, times.parse().unwrap_or_else(|_| panic!("calls.txt: how often in {line:?}")))
            } else {
                panic!("calls.txt: neither `->` nor `<=` in {line:?}");
            }
        })
        .collect()
}

/// A function, and how often each limited one may still come: what a depth depends on.
type Place = (u64, Vec<u32>);

/// Finds the deepest paths of the image.
#[derive(Debug)]
pub struct Stack<'a> {
    code: &'a Code,
    lines: Vec<Line<'a>>,
    /// Depth of what was looked at, and where its deepest way goes on.
    known: BTreeMap<Place, (u64, Option<Place>)>,
}

impl<'a> Stack<'a> {
    /// Of this image, with the reviewed list.
    pub fn of(code: &'a Code) -> Self {
        Self { code, lines: list(LIST), known: BTreeMap::new() }
    }

    /// The deepest way down from a function.
    ///
    /// # Errors
    /// It cannot be said, and why.
    pub fn deepest(&mut self, entry: &str) -> Result<Path, Failure> {
        let at = self.code.find(entry).ok_or_else(|| format!("the image has no {entry}"))?;
        let limits =
            self.lines.iter().filter_map(|line| if let Line::AtMost(_, most) = line { Some(*most) } else { None });
        let start = (at, limits.collect());
        let bytes = self.depth(&start, &mut Vec::new())?;
        let (mut steps, mut next) = (Vec::new(), Some(start));
        while let Some(place) = next {
            steps.push((self.code.functions[&place.0].body.frame(), self.name(place.0)));
            next = self.known.get(&place).and_then(|(_, next)| next.clone());
        }
        Ok(Path { bytes, steps })
    }

    /// Where the functions begin that can be reached from an entry, and what they are called; the entry is one of them.
    ///
    /// # Errors
    /// It cannot be said, and why.
    pub fn reached(&self, entry: &str) -> Result<BTreeMap<u64, String>, Failure> {
        let mut open = vec![self.code.find(entry).ok_or_else(|| format!("the image has no {entry}"))?];
        let mut seen = BTreeMap::new();
        while let Some(at) = open.pop() {
            if seen.insert(at, self.name(at)).is_none() && !self.takes_none(at) {
                open.extend(self.callees(at)?);
            }
        }
        Ok(seen)
    }

    /// Whether a line says that it never stands on the stack.
    fn takes_none(&self, at: u64) -> bool {
        self.lines.iter().any(|line| matches!(line, Line::AtMost(name, 0) if self.is(at, name)))
    }

    /// Functions whose address is taken and of which no line says who calls them.
    pub fn unclaimed(&self) -> Vec<String> {
        let claimed = |at: &u64| {
            self.lines
                .iter()
                .any(|line| matches!(line, Line::Calls(_, callees) if callees.iter().any(|name| self.is(*at, name))))
        };
        self.code.taken.iter().filter(|at| !claimed(at)).map(|at| self.name(*at)).collect()
    }

    fn name(&self, at: u64) -> String {
        self.code.functions[&at].names[0].clone()
    }

    /// Whether one of a function's names begins with `pattern`; where that begins with `*`, whether one holds the rest of it.
    fn is(&self, at: u64, pattern: &str) -> bool {
        let fits = |name: &String| match pattern.strip_prefix('*') {
            Some(part) => name.contains(part),
            None => name.starts_with(pattern),
        };
        self.code.functions[&at].names.iter().any(fits)
    }

    /// Where a function goes.
    fn callees(&self, at: u64) -> Result<Vec<u64>, Failure> {
        let function = &self.code.functions[&at];
        if let Some(target) = function.names.iter().find_map(|name| veneer(name)) {
            let plain = format!("{:#}", rustc_demangle::demangle(target));
            return self
                .code
                .find(&plain)
                .map(|at| vec![at])
                .ok_or_else(|| format!("{plain}: called, and not there").into());
        }
        if let Some(astray) = function.body.astray {
            return Err(
                format!("{} moves the stack pointer at {astray:#x} to where cannot be said", self.name(at)).into()
            );
        }
        let mut callees = Vec::new();
        for target in &function.body.calls {
            if !self.code.functions.contains_key(target) {
                return Err(format!("{} goes to {target:#x}, where no function begins", self.name(at)).into());
            }
            callees.push(*target);
        }
        if function.body.by_pointer > 0 {
            let patterns: Vec<&str> = (self.lines.iter())
                .filter_map(|line| match line {
                    Line::Calls(callers, callees) if callers.iter().any(|name| self.is(at, name)) => Some(callees),
                    _ => None,
                })
                .flatten()
                .copied()
                .collect();
            if patterns.is_empty() {
                return Err(
                    format!("{} calls through a pointer, and calls.txt does not say what", self.name(at)).into()
                );
            }
            callees.extend(self.code.taken.iter().filter(|taken| patterns.iter().any(|name| self.is(**taken, name))));
        }
        Ok(callees)
    }

    fn depth(&mut self, place: &Place, path: &mut Vec<Place>) -> Result<u64, Failure> {
        if let Some((bytes, _)) = self.known.get(place) {
            return Ok(*bytes);
        }
        if path.contains(place) {
            let names: Vec<String> =
                path.iter().skip_while(|on_it| *on_it != place).map(|place| self.name(place.0)).collect();
            return Err(
                format!("{} calls itself, and calls.txt does not say how often", names.join(", which calls ")).into()
            );
        }
        let (at, mut left) = place.clone();
        let limited: Vec<&str> = self
            .lines
            .iter()
            .filter_map(|line| if let Line::AtMost(name, _) = line { Some(*name) } else { None })
            .collect();
        for (name, left) in limited.into_iter().zip(&mut left) {
            if self.is(at, name) {
                if *left == 0 {
                    return Ok(0);
                }
                *left -= 1;
            }
        }
        path.push(place.clone());
        let mut deepest = (0, None);
        for callee in self.callees(at)? {
            let next = (callee, left.clone());
            let bytes = self.depth(&next, path)?;
            if bytes > deepest.0 {
                deepest = (bytes, Some(next));
            }
        }
        path.pop();
        let bytes = self.code.functions[&at].body.frame() + deepest.0;
        self.known.insert(place.clone(), (bytes, deepest.1));
        Ok(bytes)
    }
}
