//! What somebody meant who wrote a name that there is none of.

use cohold_core::settings::LawInfo;

use super::{OWN, Scene};

impl Scene {
    /// What a mistyped key may have meant.
    pub(super) fn hint(&self, key: &str) -> String {
        if let Some((_, now)) = RENAMED.iter().find(|(before, _)| *before == key) {
            return format!("; it is {now} now");
        }
        if key.starts_with("peer.") {
            return format!("; what one end alone may be told is peer.1. or peer.2. and a key of {}", OWN.join(", "));
        }
        let keys = self.keys();
        if let Some((table, _)) =
            key.rsplit_once('.').filter(|(table, _)| !keys.iter().any(|(k, _)| k.starts_with(&format!("{table}."))))
        {
            let mut tables: Vec<&str> =
                keys.iter().filter_map(|(name, _)| name.rsplit_once('.')).map(|(t, _)| t).collect();
            tables.dedup();
            return format!("; there is no table {table}, the tables are {}", tables.join(", "));
        }
        let near = nearest(key, keys.iter().map(|(name, _)| name.as_str()));
        near.map_or_else(String::new, |name| format!("; did you mean {name}?"))
    }
}

/// Keys that are called otherwise since they have another unit.
const RENAMED: [(&str, &str); 3] = [
    ("safety.fade_packets", "safety.fade_s, in s"),
    ("safety.disengage_packets", "safety.disengage_s, in s"),
    ("safety.peer_lost_packets", "safety.peer_lost_s, in s"),
];

/// Which law is meant by a name that none of these has, in words: the one that had it before, or else one whose name is like it.
pub fn law_meant(word: &str, laws: &[LawInfo]) -> Option<String> {
    if let Some(law) = laws.iter().find(|law| law.formerly == word && !word.is_empty()) {
        return Some(format!("it is {} now", law.name));
    }
    nearest(word, laws.iter().map(|law| law.name)).map(|name| format!("did you mean {name}?"))
}

/// The name that a misspelt one is most like, if it is like any.
pub fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let likely = names.map(|name| (strsim::jaro_winkler(name, word), name)).filter(|(likeness, _)| *likeness > 0.8);
    likely.max_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, name)| name)
}
