//! Where a contact with a stop that gives way ends.

/// Where a contact with a [`Spring`](crate::Spring) ends that has a dashpot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ContactRelease {
    /// Where the gap opens, p = 0: the dashpot pulls before that.
    Gap,
    /// Where the force is zero: the stop goes back by itself, and is met again where it is.
    Force,
    /// Where the force is zero, `max(0, f)`: the stop has no place of its own.
    Clipped,
}

impl ContactRelease {
    /// All, each with its name in Python.
    pub const ALL: [(Self, &'static str); 3] = [
        (Self::Gap, "gap"),
        (Self::Force, "force"),
        (Self::Clipped, "clipped"),
    ];
}
