//! The direction in which an impact on a stop changes the velocity (theory 1).

use nalgebra::DVector;

/// The direction in which an impact changes the velocity.
///
/// Directions other than those of inertia have two limits. They may feed a motion: between stops that strike each other it can grow
/// beyond all bounds within a finite time, where impacts come nearer to each other than times in doubles tell, and what is said of
/// it from then on means nothing. And where stops whose normals depend on each other (two at one place, three on two coordinates)
/// react in different directions, more than one motion obeys the laws: what is found is one of them, and may pass a stop by 1e-8 of
/// the motion while forces change hands.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Reaction {
    /// `b = M^-1 n`: Newton's law, coupled by inertia.
    #[default]
    Inertia,
    /// `b = n`: each coordinate reset alone, the source paper's law. Not energy-safe where the mass couples them.
    Coordinate,
    /// `b` itself, shape `(n,)`, with `n.b > 0`.
    Direction(DVector<f64>),
}
