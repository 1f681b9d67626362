//! Stops at rest in contact: which of them push, by one derivative of their gaps (theory 9), and which carry what dependent ones share.

use crate::error::Result;
use crate::impact::{Release, contact_forces};
use crate::linalg::rank;
use crate::tolerance::DEPENDENT;
use nalgebra::{DMatrix, DVector};

/// The k stops that are at rest in contact, and the n coordinates.
pub(super) struct Resting<'a> {
    pub stops: &'a [usize],
    /// Their normals as columns, shape `(n, k)`, [-].
    pub normals: DMatrix<f64>,
    /// Their Delassus matrix `N^T B`, shape `(k, k)`, [1/kg].
    pub delassus: DMatrix<f64>,
    /// The sizes of the terms of the accelerations of their gaps, shape `(k,)`, [m/s^2].
    pub sizes: Vec<f64>,
    /// Those sizes before the impacts of this instant, shape `(k,)`, [m/s^2].
    pub prior_sizes: Vec<f64>,
    /// Derivatives of gaps below this part of what others do to them are zero.
    pub steady: f64,
}

impl Resting<'_> {
    /// The stops of contacts, in order.
    pub fn stops_of(&self, contacts: &[usize]) -> Vec<usize> {
        contacts.iter().map(|&i| self.stops[i]).collect()
    }

    /// The law of contact for a derivative of some gaps, each known to a slack, and that of their forces two orders lower, beside
    /// contacts that are held.
    pub fn law_of(
        &self,
        held: &[usize],
        free: &[usize],
        derivatives: &[[f64; 2]],
    ) -> Result<ContactSplit> {
        let opening = DVector::from_iterator(free.len(), derivatives.iter().map(|d| d[0]));
        let reduced = reduced(&self.delassus, held, free);
        // The effect of the forces on the others on a gap has their errors.
        let reached = |i: usize, j: usize| (reduced[(i, j)] / reduced[(j, j)] * opening[j]).abs();
        let shaken = |i: usize| (0..free.len()).fold(0.0, |most: f64, j| most.max(reached(i, j)));
        let slack = DVector::from_fn(free.len(), |i, _| {
            derivatives[i][1].max(self.steady * shaken(i))
        });
        let forces = contact_forces(&reduced, &opening, &slack).ok();
        let (mut law, mut shares) = (ContactSplit::default(), Vec::new());
        for (k, &i) in free.iter().enumerate() {
            match forces.as_ref().map(|forces| &forces[k]) {
                Some(force) if force.release == Release::Stays => shares.push((k, force.force)),
                Some(force) if force.release == Release::Leaves => law.opening.push(i),
                _ => law.undecided.push(i),
            }
        }
        let n_free = self.normals.nrows().saturating_sub(held.len());
        let carrying = carriers(&reduced, shares, n_free, self.steady * opening.amax())?;
        let contacts = |places: Vec<usize>| places.into_iter().map(|k| free[k]);
        law.pressed = contacts(carrying.held).collect();
        law.undecided.extend(contacts(carrying.idle));
        Ok(law)
    }
}

/// Which contacts push and which open, by one derivative of their gaps.
#[derive(Default)]
pub(super) struct ContactSplit {
    /// Those that begin to push.
    pub pressed: Vec<usize>,
    /// Those that open.
    pub opening: Vec<usize>,
    pub undecided: Vec<usize>,
}

/// Contacts that are held by forces, and what those do to each.
#[derive(Default)]
pub(super) struct Carrying {
    /// Those that carry all of it.
    pub held: Vec<usize>,
    /// Those that carry nothing then; where their normals depend on those held, their gaps stay as they are.
    pub idle: Vec<usize>,
}

/// Of contacts held by given forces those that can carry all of it, their normals independent, and the others
/// (Caratheodory): what dependent normals share may pull at one of them. Forces that accelerate a gap by no more than `nothing` are
/// none then. The bodies can move in `n_free` ways.
pub(super) fn carriers(
    delassus: &DMatrix<f64>,
    mut shares: Vec<(usize, f64)>,
    n_free: usize,
    nothing: f64,
) -> Result<Carrying> {
    let mut carrying = Carrying::default();
    while shares.len() > 1 {
        let held: Vec<usize> = shares.iter().map(|&(i, _)| i).collect();
        let among = delassus.select_rows(&held).select_columns(&held);
        let allowed = DEPENDENT * among.amax();
        let none = DVector::zeros(held.len());
        let idle = rank::solve(&among, &none, allowed)?.null_space;
        // Forces along other directions than those of inertia do not replace each other, but where nothing is left to move.
        let is_inertial = (&among - among.transpose()).amax() <= allowed;
        let is_fixed = held.len() - idle.ncols() == n_free;
        if idle.ncols() == 0 || !(is_inertial || is_fixed) {
            break;
        }
        let along = idle.column(0);
        let least = DEPENDENT * along.amax();
        let ratio = |k: usize| shares[k].1 / along[k];
        let changing = (0..held.len()).filter(|&k| along[k].abs() > least);
        let first = changing.min_by(|&a, &b| ratio(a).abs().total_cmp(&ratio(b).abs()));
        let first = first.expect("a vector of length one");
        let step = ratio(first);
        for (share, part) in shares.iter_mut().zip(along.iter()) {
            share.1 = (share.1 - step * part).max(0.0);
        }
        carrying.idle.push(shares.remove(first).0);
        // Who carries nothing may be needed where another is not.
        let (carrying_all, idle) = (shares.into_iter())
            .partition(|&(i, share): &(usize, f64)| delassus[(i, i)] * share > nothing);
        shares = carrying_all;
        carrying.idle.extend(idle.into_iter().map(|(i, _)| i));
    }
    carrying.held = shares.into_iter().map(|(i, _)| i).collect();
    Ok(carrying)
}

/// Whether the normals of some contacts depend on each other.
pub(super) fn depend(normals: &DMatrix<f64>, contacts: &[usize]) -> Result<bool> {
    for (k, &contact) in contacts.iter().enumerate() {
        if is_bound(normals, &contacts[..k], contact)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether the gap of a contact cannot change while some others are held: its normal depends on theirs.
pub(super) fn is_bound(normals: &DMatrix<f64>, held: &[usize], contact: usize) -> Result<bool> {
    if held.is_empty() {
        return Ok(false);
    }
    let normal = normals.column(contact).into_owned();
    rank::depends_on(&normal, &normals.select_columns(held))
}

/// The Delassus matrix of some contacts while others are held.
pub(super) fn reduced(delassus: &DMatrix<f64>, held: &[usize], contacts: &[usize]) -> DMatrix<f64> {
    let part =
        |rows: &[usize], columns: &[usize]| delassus.select_rows(rows).select_columns(columns);
    let own = part(contacts, contacts);
    if held.is_empty() {
        return own;
    }
    let among = part(held, held);
    let allowed = DEPENDENT * among.amax();
    match rank::pseudo_inverse(&among, allowed) {
        Ok(inverse) => own - part(contacts, held) * inverse * part(held, contacts),
        Err(_) => own,
    }
}
