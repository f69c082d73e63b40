//! The few lines that a page may have said to a board.

/// What a page may have said to a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Line {
    Arm,
    Clear,
    /// Do the signs of this joint's motor and encoder agree? It pushes both ways.
    Check(u8),
}

impl Line {
    /// As a page writes it.
    pub(super) fn from_text(text: &str) -> Option<Self> {
        match text {
            "arm" => Some(Self::Arm),
            "clear" => Some(Self::Clear),
            "check 1" => Some(Self::Check(1)),
            "check 2" => Some(Self::Check(2)),
            _ => None,
        }
    }

    /// As a board reads it.
    pub(super) fn text(self) -> String {
        match self {
            Self::Arm => "arm".to_owned(),
            Self::Clear => "clear".to_owned(),
            Self::Check(joint) => format!("check {joint}"),
        }
    }
}
