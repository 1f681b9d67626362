//! What a periodic motion is pieced together from, along modal flights and along steps.

pub(in crate::orbit) mod chatter;
pub(in crate::orbit) mod modal;
pub(in crate::orbit) mod pieces;
pub(in crate::orbit) mod stepped;
