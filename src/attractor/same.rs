//! Which motions have settled on one attractor.

use crate::attractor::kind::AttractorKind;
use crate::attractor::state_box::StateBox;
use crate::tolerance::IN_SET;
use nalgebra::DMatrix;

/// Points nearer to each other than this part of the box are one.
const SAME: f64 = 1e-6;
/// Sets are one if more than this part of the points of each are in the other.
const SHARED: f64 = 0.5;

/// What is seen of an attractor: its kind, its period and its points.
pub(crate) type Seen = (AttractorKind, usize, DMatrix<f64>);

/// Motions on one attractor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Group {
    /// The one that stands for all.
    pub first: usize,
    pub count: usize,
}

/// Which motions are on one attractor.
pub(crate) struct Groups {
    /// The largest first.
    pub all: Vec<Group>,
    /// The place of the group of each motion; `None` of those without an attractor.
    pub of_each: Vec<Option<usize>>,
}

/// Those that are one taken together, in their order.
pub(crate) fn groups(seen: &[Option<Seen>], around: &StateBox) -> Groups {
    let mut all: Vec<Group> = Vec::new();
    let mut of_each = Vec::with_capacity(seen.len());
    for (i, own) in seen.iter().enumerate() {
        let Some(own) = own else {
            of_each.push(None);
            continue;
        };
        let is_known = |group: &Group| {
            let first = seen[group.first].as_ref();
            first.is_some_and(|other| are_same(own, other, around))
        };
        let place = all.iter().position(is_known).unwrap_or_else(|| {
            all.push(Group { first: i, count: 0 });
            all.len() - 1
        });
        let group = &mut all[place];
        group.count += 1;
        // A set on which some start has come to rest on a stop repeats itself, however long others have not.
        let kind = seen[group.first].as_ref().map(|first| first.0);
        if kind == Some(AttractorKind::Chaotic) && own.0 == AttractorKind::Periodic {
            group.first = i;
        }
        of_each.push(Some(place));
    }
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by_key(|&k| std::cmp::Reverse(all[k].count));
    let mut rank = vec![0; all.len()];
    for (place, &k) in order.iter().enumerate() {
        rank[k] = place;
    }
    Groups {
        all: order.iter().map(|&k| all[k]).collect(),
        of_each: of_each
            .into_iter()
            .map(|k| k.map(|k: usize| rank[k]))
            .collect(),
    }
}

/// Whether two are one: orbits by their points, in whatever order they begin; sets by how near their points are to each other's.
fn are_same(a: &Seen, b: &Seen, around: &StateBox) -> bool {
    if a.1 != b.1 {
        return false;
    }
    let (one, other) = (&a.2, &b.2);
    if a.1 > 0 {
        return are_points_within(one, other, around, SAME);
    }
    is_in(one, other, around) && is_in(other, one, around)
}

/// Whether points, one in each period, are no farther from each other than a part of the box from some period on.
pub(crate) fn are_points_within(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    around: &StateBox,
    part: f64,
) -> bool {
    let m = a.nrows();
    let is_near = |i: usize, j: usize| around.distance((a, i), (b, j)) <= part;
    b.nrows() == m && (0..m).any(|late| (0..m).all(|k| is_near(k, (k + late) % m)))
}

/// Whether most points of one set are in another.
fn is_in(a: &DMatrix<f64>, b: &DMatrix<f64>, around: &StateBox) -> bool {
    let apart = |i: usize, j: usize| around.distance((a, i), (b, j));
    let nearest = |i: usize| {
        (0..b.nrows())
            .map(|j| apart(i, j))
            .fold(f64::INFINITY, f64::min)
    };
    let within = IN_SET * spacing(b, around);
    let count = (0..a.nrows()).filter(|&i| nearest(i) <= within).count();
    count as f64 > SHARED * a.nrows() as f64
}

/// The median distance of points to their nearest neighbours.
pub(crate) fn spacing(points: &DMatrix<f64>, around: &StateBox) -> f64 {
    let apart = |i: usize, j: usize| around.distance((points, i), (points, j));
    let nearest = |i: usize| {
        let others = (0..points.nrows()).filter(|&j| j != i);
        others.map(|j| apart(i, j)).fold(f64::INFINITY, f64::min)
    };
    let mut all: Vec<f64> = (0..points.nrows()).map(nearest).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}
