//! What holds of the files themselves: where imports point, what comments cite, what names say.

mod layers;
mod names;
mod sources;
mod theory;
