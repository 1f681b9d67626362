//! What the rules of contact say along flights that are integrated (theory 5, 6).

use crate::error::Result;
use crate::event::first_root::FirstRoot;
use crate::event::polynomial::{EndValues, Judgement, Quintic};
use crate::event::probed::{Probed, STEP_PROBES};
use crate::event::series::{GapSeries, GapTerms};
use crate::hybrid::{FlightPieces, HybridMaps, IntegratedMaps, OrbitStep, SeriesPiece};
use crate::impact::Impact;
use crate::law::Regime;
use crate::model::are_coupled;
use crate::orbit::orbit_data::OrbitArc;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Rule, Touch};
use crate::orbit::verdict::judge::{is_met, judge_impacts, judge_reached};
use crate::orbit::verdict::lasting::{is_low_bounce, judge_force};
use crate::orbit::verdict::thrown::{HeldAtImpact, judge_thrown};
use crate::tolerance::{INTEGRATED_MARGIN, SHORTEST_JUDGED_STEP};
use nalgebra::DVector;

/// Judges flights that are integrated.
pub(crate) struct IntegratedJudge<'a> {
    pub maps: &'a IntegratedMaps,
}

impl IntegratedJudge<'_> {
    /// Judges the impacts, every gap along every flight, and the contact forces of what is held.
    pub fn admissibility(
        &self,
        flights: &[(f64, FlightPieces)],
        arcs: &[OrbitArc],
        impacts: &[Impact],
        rate: f64,
    ) -> Result<Admissibility> {
        let mut found = Admissibility::default();
        let sizes: Vec<f64> = (0..self.maps.contacts.len())
            .map(|stop| self.size(stop, flights))
            .collect::<Result<_>>()?;
        judge_impacts(
            impacts,
            |stop| INTEGRATED_MARGIN * sizes[stop] * rate,
            &mut found,
        );
        self.judge_ends(flights, arcs, impacts, (&sizes, rate), &mut found)?;
        for ((start, pieces), arc) in flights.iter().zip(arcs) {
            if arc.accumulation().is_some() {
                continue;
            }
            if let FlightPieces::Steps(steps) = pieces {
                self.search_forces(arc.regime(), (*start, steps), flights, &mut found)?;
            }
            for (stop, &size) in sizes.iter().enumerate() {
                let (regime, margin) = (arc.regime(), INTEGRATED_MARGIN * size);
                let order = match arc.departure() {
                    Some(released) if released == stop => 3,
                    _ if arc.hits().contains(&stop) => {
                        self.order((*start, pieces), stop, margin * rate)?
                    }
                    _ => 0,
                };
                let flight = (*start, pieces);
                let is_open = regime.leaves_free(stop);
                if !is_open || self.is_low_bounce(flight, (regime, stop), margin)? {
                    continue;
                }
                match pieces {
                    FlightPieces::Steps(steps) => {
                        self.search((*start, steps), (stop, order), regime, margin, &mut found)?;
                    }
                    FlightPieces::Series(pieces) => {
                        self.search_series((*start, pieces), (stop, order), margin, &mut found);
                    }
                }
            }
        }
        Ok(found)
    }

    /// Judges the stops at the ends of flights that are not hit there.
    fn judge_ends(
        &self,
        flights: &[(f64, FlightPieces)],
        arcs: &[OrbitArc],
        impacts: &[Impact],
        (sizes, rate): (&[f64], f64),
        found: &mut Admissibility,
    ) -> Result<()> {
        let each = flights.iter().zip(arcs);
        let following = each.clone().cycle().skip(1);
        for (((start, pieces), arc), (&(next, _), next_arc)) in each.zip(following) {
            let Some((span, state)) = pieces.end() else {
                continue;
            };
            let end = start + span;
            for (stop, &size) in sizes.iter().enumerate() {
                if is_met(impacts, stop, next, [arc, next_arc]) {
                    continue;
                }
                let gap = self.gap(stop, end, &state)?;
                let margin = INTEGRATED_MARGIN * size;
                judge_reached((stop, next), gap, (margin, margin * rate), found);
            }
            let own = HeldAtImpact {
                before: arc.regime(),
                after: next_arc.regime(),
                time: next,
                impacts,
            };
            let state = DVector::from_vec(state);
            let coupling = |one: usize, other: usize| {
                let opens = self.maps.gap(one, end, &state)?.gradient;
                Ok(-opens.dot(&self.maps.reaction(other, &state)?))
            };
            let slow = |stop: usize| INTEGRATED_MARGIN * sizes[stop] * rate;
            judge_thrown(own, coupling, slow, found)?;
        }
        Ok(())
    }

    /// The gap of a stop and its rate.
    fn gap(&self, stop: usize, t: f64, x: &[f64]) -> Result<[f64; 2]> {
        let (q, v) = x.split_at(x.len() / 2);
        let value = self.maps.contacts[stop].along(|| self.maps.moment(t), (q, v, v), 0.0)?;
        Ok([value.gap, value.speed])
    }

    /// The same with the acceleration.
    fn bent_gap(
        &self,
        (regime, stop): (&Regime, usize),
        t: f64,
        x: &[f64],
        step: f64,
    ) -> Result<[f64; 3]> {
        let a = self.maps.rate_of(regime, self.maps.moment(t), x)?;
        let (q, v) = x.split_at(x.len() / 2);
        let value = self.maps.contacts[stop].along(|| self.maps.moment(t), (q, v, &a), step)?;
        Ok([value.gap, value.speed, value.acceleration])
    }

    /// The order of the zero that a gap has behind an impact: two where that has taken all speed but what is slow.
    fn order(
        &self,
        (start, pieces): (f64, &FlightPieces),
        stop: usize,
        slow: f64,
    ) -> Result<usize> {
        let Some((_, first)) = pieces.starts().next() else {
            return Ok(1);
        };
        let [_, opening] = self.gap(stop, start, &first)?;
        Ok(if opening.abs() <= slow { 2 } else { 1 })
    }

    /// Whether a flight stays within the margin of a stop between two contacts with it.
    fn is_low_bounce(
        &self,
        (start, pieces): (f64, &FlightPieces),
        (regime, stop): (&Regime, usize),
        margin: f64,
    ) -> Result<bool> {
        let (Some((_, first)), Some((span, last))) = (pieces.starts().next(), pieces.end()) else {
            return Ok(false);
        };
        let plain = |t: f64, x: &[f64]| self.gap(stop, t, x).map(|[gap, speed]| [gap, speed, 0.0]);
        let bent = |t: f64, x: &[f64]| self.bent_gap((regime, stop), t, x, span);
        let (first, last) = ((start, &first[..]), (start + span, &last[..]));
        Ok(is_low_bounce(
            plain(first.0, first.1)?,
            plain(last.0, last.1)?,
            span,
            margin,
        ) && is_low_bounce(bent(first.0, first.1)?, bent(last.0, last.1)?, span, margin))
    }

    /// Searches the contact forces of the stops held for the worst pull, on the quartic through five values of each step.
    fn search_forces(
        &self,
        regime: &Regime,
        (start, steps): (f64, &[OrbitStep]),
        flights: &[(f64, FlightPieces)],
        found: &mut Admissibility,
    ) -> Result<()> {
        if regime.is_free() || steps.is_empty() {
            return Ok(());
        }
        let mut along = Vec::with_capacity(steps.len());
        for step in steps {
            let mut nodes = Vec::with_capacity(5);
            for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let at = self.maps.moment(start).after(step.start + part * step.h);
                nodes.push(
                    self.maps
                        .forces(regime, at, &step.dense.at(part * step.h))?,
                );
            }
            along.push((start + step.start, step.h, nodes));
        }
        let n_forces = along[0].2[0].len();
        for k in 0..n_forces {
            let stop = along[0].2[0][k].0;
            let of_stop: Vec<_> = along
                .iter()
                .map(|(t, h, nodes)| (*t, *h, std::array::from_fn(|i| nodes[i][k].1)))
                .collect();
            let mobility = self.mobility(stop, start, &steps[0].dense.at(0.0))?;
            let size = self.fastest(stop, flights)? / mobility;
            judge_force(stop, &of_stop, (INTEGRATED_MARGIN, size), found);
        }
        Ok(())
    }

    /// The largest acceleration that a motion has along its flights towards a stop, or from it: what forces are made of that cancel at a
    /// release.
    fn fastest(&self, stop: usize, flights: &[(f64, FlightPieces)]) -> Result<f64> {
        let mut most = 0.0f64;
        for (start, pieces) in flights {
            for (local, x) in pieces.starts() {
                let [_, _, acceleration] =
                    self.bent_gap((Regime::free(), stop), start + local, &x, 0.0)?;
                most = most.max(acceleration.abs());
            }
        }
        Ok(most)
    }

    /// The acceleration that a force of one on a stop gives its gap.
    fn mobility(&self, stop: usize, t: f64, x: &[f64]) -> Result<f64> {
        let x = DVector::from_column_slice(x);
        let at = self.maps.gap(stop, t, &x)?;
        Ok(-at.gradient.dot(&self.maps.reaction(stop, &x)?))
    }

    /// Whether an impact on one of two stops changes the normal velocity at the other, at an instant that hits both.
    pub fn is_coupled(&self, a: usize, b: usize, flights: &[OrbitArc]) -> bool {
        let is_both = |own: &&OrbitArc| own.hits().contains(&a) && own.hits().contains(&b);
        flights.iter().filter(is_both).any(|flight| {
            let q: Vec<f64> = flight.after.iter().map(|z| z[0]).collect();
            are_coupled(
                &self.maps.contacts[a],
                &self.maps.contacts[b],
                &self.maps.system,
                &q,
            )
        })
    }

    /// The size of the motion along one gap.
    fn size(&self, stop: usize, flights: &[(f64, FlightPieces)]) -> Result<f64> {
        let mut size = 0.0f64;
        for (start, pieces) in flights {
            for (local, x) in pieces.starts() {
                let (q, v) = x.split_at(x.len() / 2);
                let at = || self.maps.moment(start + local);
                let value = self.maps.contacts[stop].along(at, (q, v, v), 0.0)?;
                size = size.max(value.size);
            }
        }
        Ok(size)
    }

    /// Searches a gap along the series of a flight.
    fn search_series(
        &self,
        (start, pieces): (f64, &[SeriesPiece]),
        (stop, first_order): (usize, usize),
        margin: f64,
        found: &mut Admissibility,
    ) {
        let Some(terms) = GapTerms::new(&self.maps.contacts[stop].surface) else {
            return;
        };
        let mut gap = GapSeries::EMPTY;
        let mut touches = Vec::new();
        for (i, piece) in pieces.iter().enumerate() {
            let order = if i == 0 { first_order } else { 0 };
            let t = start + piece.start;
            terms.along(piece.motion(), &mut gap);
            gap.within(margin);
            touches.clear();
            if gap.clone().first_contact(order, piece.h, &mut touches) != FirstRoot::None {
                let (x, least) = gap.lowest(order, piece.h);
                if -least > margin {
                    found.keep_worst(Breach {
                        stop,
                        time: t + x,
                        depth: -least,
                        rule: Rule::Passed,
                    });
                }
            }
            found.touches.extend(touches.iter().map(|&(x, gap)| Touch {
                stop,
                time: t + x,
                gap,
            }));
        }
    }

    fn search(
        &self,
        (start, steps): (f64, &[OrbitStep]),
        (stop, first_order): (usize, usize),
        regime: &Regime,
        margin: f64,
        found: &mut Admissibility,
    ) -> Result<()> {
        let contact = &self.maps.contacts[stop];
        if contact.surface.is_nonlinear()
            && let Some(curvature) = contact.surface.curvature()
        {
            let searched = (stop, first_order, curvature);
            return self.search_bounded((start, steps), searched, regime, margin, found);
        }
        let ends = |t: f64, x: &[f64], h: f64| -> Result<[f64; 3]> {
            let a = self.maps.rate_of(regime, self.maps.moment(t), x)?;
            let (q, v) = x.split_at(x.len() / 2);
            let value = contact.along(|| self.maps.moment(t), (q, v, &a), h)?;
            Ok([value.gap, value.speed, value.acceleration])
        };
        // The accuracy of the flights is the rounding of an orbit.
        let judged = Judgement {
            rounding: margin,
            error: 0.0,
        };
        // Steps may be long for the motion of a stop: pieces of them are as short as its quintic asks.
        let motion = contact.motion.as_ref();
        let longest = motion.map_or(f64::INFINITY, |motion| motion.quintic_step(margin));
        let pieces = steps.iter().flat_map(|step| {
            let count = (step.h / longest).ceil().max(1.0);
            let h = step.h / count;
            (0..count as usize).map(move |k| (step, k as f64 * h, h))
        });
        let mut left: Vec<_> = pieces.collect();
        left.reverse();
        let mut order = first_order;
        let shortest = left
            .iter()
            .map(|(_, _, h)| h * SHORTEST_JUDGED_STEP)
            .fold(f64::INFINITY, f64::min);
        while let Some((step, from, h)) = left.pop() {
            let t = start + step.start + from;
            let known = EndValues::new(
                ends(t, &step.dense.at(from), h)?,
                ends(t + h, &step.dense.at(from + h), h)?,
                h,
                order,
            );
            let is_nonlinear = contact.surface.is_nonlinear();
            if known.are_clear(order, margin) && !is_nonlinear {
                order = 0;
                continue;
            }
            let quintic = Quintic::new(&known);
            let mut lowest = quintic.lowest();
            if is_nonlinear {
                let mut probed = Probed([0.0; STEP_PROBES.len()]);
                for (gap, x) in probed.0.iter_mut().zip(STEP_PROBES) {
                    let q = step.dense.at(from + x * h);
                    let at = self.maps.moment(t + x * h);
                    *gap = contact.gap(&q[..q.len() / 2], at)?;
                }
                if probed.is_unlike(&quintic, margin) && h > shortest {
                    let half = 0.5 * h;
                    left.extend([(step, from + half, half), (step, from, half)]);
                    continue;
                }
                let deepest = probed.deepest();
                if deepest.1 > lowest.1.max(margin) {
                    lowest = deepest;
                }
            }
            let mut touches = Vec::new();
            let along = quintic.first_contact(order, judged, &mut touches);
            order = 0;
            let (x, depth) = lowest;
            let is_passed = along != FirstRoot::None || lowest != quintic.lowest();
            if is_passed && depth > margin {
                found.keep_worst(Breach {
                    stop,
                    time: t + x * h,
                    depth,
                    rule: Rule::Passed,
                });
            }
            found.touches.extend(touches.iter().map(|&(x, gap)| Touch {
                stop,
                time: t + x * h,
                gap,
            }));
        }
        Ok(())
    }
}
