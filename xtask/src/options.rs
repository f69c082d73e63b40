//! The command line of a chore, read by what its help says may follow it: `[--flag]`, `[--name VALUE]`.

use crate::run::Failure;

/// What was given, in its order; a flag has no value.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Options<'a>(Vec<(&'a str, Option<&'a str>)>);

impl<'a> Options<'a> {
    /// Takes `--name value` and `--name=value`; what is wrong is one line, before anything is done.
    pub(crate) fn read(chore: &str, declared: &str, words: &[&'a str]) -> Result<Self, Failure> {
        let mut given = Vec::new();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let (name, attached) = word.split_once('=').map_or((*word, None), |(name, value)| (name, Some(value)));
            let behind = |one: &str| one.strip_prefix(name.strip_prefix("--")?)?.chars().next();
            let mut kinds = declared.split("--").skip(1).filter_map(behind);
            given.push(match kinds.find(|sign| matches!(sign, ' ' | ']')) {
                Some(']') if attached.is_none() => (name, None),
                Some(' ') => match attached.or_else(|| words.next().copied()) {
                    None => {
                        let which = format!("{name} needs a value; `cargo xtask {chore} --help` says which");
                        return Err(Failure::usage(which));
                    }
                    value => (name, value),
                },
                _ => {
                    let lists = format!("there is no option {word}; `cargo xtask {chore} --help` lists them");
                    return Err(Failure::usage(lists));
                }
            });
        }
        Ok(Self(given))
    }

    /// Whether it was given.
    pub(crate) fn flag(&self, name: &str) -> bool {
        self.0.iter().any(|(given, _)| *given == name)
    }

    /// What was given last.
    pub(crate) fn value(&self, name: &str) -> Option<&'a str> {
        self.0.iter().rev().find(|(given, _)| *given == name)?.1
    }

    /// All of it again.
    pub(crate) fn words(&self) -> impl Iterator<Item = &'a str> {
        self.0.iter().flat_map(|(name, value)| [Some(*name), *value]).flatten()
    }

    /// Every option with its value; a flag's is empty.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (&'a str, &'a str)> {
        self.0.iter().map(|(name, value)| (*name, value.unwrap_or_default()))
    }
}
