//! What holds of the files themselves: where imports point, and what comments cite.

mod layers;
mod sources;
mod theory;
