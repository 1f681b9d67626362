//! What holds of the files themselves: where imports point, what names say, what comments and documents cite.

mod documents;
mod layers;
mod names;
mod sources;
mod theory;
