//! What happens to the contacts at one instant of the referee's run: a gap closes, impulses act, and stops with no normal speed
//! stay or are left.

use crate::runs::double_double::{Dd, Matrix, dot};
use crate::runs::law::{complementary, impulses};
use crate::runs::record::{AMBIGUOUS, Hit, Stretch};
use crate::runs::simulator::{AHEAD, CLOSED, Contact, Run, scattered};

/// Part of the largest impulse at one instant below which others are nothing.
const NO_IMPACT: f64 = 1e-12;

/// Why a run is one of several.
pub const SEVERAL: &str = "several sets of contact forces solve the law";

/// Whether some of the forces move the gaps otherwise than others.
fn are_several(delassus: &Matrix, solutions: &[Vec<Dd>], scale: f64) -> bool {
    let effects: Vec<Vec<Dd>> = solutions.iter().map(|f| delassus.times(f)).collect();
    let differ = |a: &[Dd], b: &[Dd]| {
        let pairs = a.iter().zip(b);
        pairs
            .into_iter()
            .any(|(a, b)| (*a - *b).abs().to_f64() > 1e-15 * scale)
    };
    effects.iter().any(|effect| differ(effect, &effects[0]))
}

impl Run<'_> {
    /// A gap closes.
    pub fn touch(&mut self, stop: usize) {
        // Stops at exactly one place stay together, whatever rounding does to the time of their contact.
        let together: Vec<usize> = (0..self.contacts.len())
            .filter(|&i| {
                self.contacts[i] == Contact::Open
                    && self.model.gap(i, &self.x).abs().to_f64() <= CLOSED * self.size(i)
            })
            .collect();
        self.blur(stop);
        self.near_place(stop, &together);
        let touching: Vec<usize> = (0..self.contacts.len())
            .filter(|&i| {
                i == stop
                    || together.contains(&i)
                    || self.contacts[i] == Contact::Held
                    || self.model.gap(i, &self.x).abs().to_f64() <= CLOSED * self.size(i)
            })
            .collect();
        self.strike(&touching);
    }

    /// Impulses on some stops.
    pub fn push(&mut self, stops: &[usize], impulses: &[Dd]) {
        let n = self.model.n;
        for (&i, &p) in stops.iter().zip(impulses) {
            let reaction = &self.model.stops[i].reaction;
            for (v, &b) in self.x[n..2 * n].iter_mut().zip(reaction) {
                *v -= b * p;
            }
        }
    }

    /// Shifts a contact by what the rounding of its gap does to its time; of one no deeper than rounding nobody knows.
    pub fn blur(&mut self, stop: usize) {
        let held = self.held.clone();
        let motion = self.motion(&held).expect("independent stops");
        let a = dot(
            &self.model.stops[stop].normal,
            &motion.acceleration(&self.x),
        );
        let speed = -self.model.opening(stop, &self.x).to_f64();
        let normal = &self.model.stops[stop].normal;
        let reach = normal.iter().map(|n| n.abs().to_f64()).sum::<f64>();
        let (bend, size) = (-a.to_f64(), self.size(stop).max(reach * self.record.q_size));
        if bend > 0.0 && speed.powi(2) < 2.0 * bend * 1e-13 * size {
            self.doubt("a graze");
        }
        let Some(roughness) = self.roughness else {
            return;
        };
        // Signs of no pattern: a shift of one sign is a stop that stands elsewhere, and changes little.
        let count = self.record.hits.len() as u64 + 1;
        let bits = scattered(count + (roughness.pattern << 32)) >> 63;
        let sign = if bits == 0 { 1.0 } else { -1.0 };
        // Sums of modes have the rounding of the largest coordinate.
        let terms = roughness.terms.max(self.record.q_size);
        let depth = sign * roughness.gap * (self.size(stop) + reach * terms);
        if speed > 0.0 && speed * speed > 10.0 * a.abs().to_f64() * depth.abs() {
            // Where a gap closes so slowly that its time is anyone's, the motion is moved by no more than a little.
            let most = 1e-6 / self.model.rate;
            let shift = Dd::from((depth / speed).clamp(-most, most));
            self.x = motion.advance(&self.x, shift);
            self.time += shift;
        }
    }

    /// Another stop that closes at practically this place, and depends on this one: which is hit is one of rounding.
    pub fn near_place(&mut self, stop: usize, together: &[usize]) {
        let terms = self.roughness.map_or(0.0, |r| r.terms);
        let g = &self.model.delassus;
        let is_near = (0..self.contacts.len()).any(|j| {
            let gap = self.model.gap(j, &self.x).to_f64();
            j != stop
                && !together.contains(&j)
                && self.contacts[j] == Contact::Open
                && (g.rows[stop][j] != Dd::ZERO || g.rows[j][stop] != Dd::ZERO)
                && self.model.opening(j, &self.x) < Dd::ZERO
                && gap.abs() > CLOSED * self.size(j)
                && gap < 1e-13 * self.size(j).max(self.record.q_size + terms)
        });
        if is_near {
            self.doubt("two stops at almost one place");
        }
    }

    /// Impulses of the stops in contact, then what stays in contact.
    pub fn strike(&mut self, touching: &[usize]) {
        if self.model.reactions_differ(touching) {
            self.doubt(AMBIGUOUS);
        }
        if touching.len() > 1 && touching.iter().any(|&i| self.faded[i]) {
            self.doubt("rest by rounding is struck");
        }
        let part = self.model.delassus.part(touching);
        let opening: Vec<Dd> = touching
            .iter()
            .map(|&i| match self.contacts[i] {
                Contact::Held => Dd::ZERO,
                _ => self.opening_at_contact(i),
            })
            .collect();
        let restitution: Vec<f64> = touching
            .iter()
            .map(|&i| self.model.stops[i].restitution)
            .collect();
        let reach = touching
            .iter()
            .flat_map(|&i| &self.model.stops[i].normal)
            .map(|x| x.abs().to_f64())
            .fold(0.0, f64::max);
        let scale = reach * self.speed_size();
        let held = self.held.clone();
        let motion = self.motion(&held).expect("independent stops");
        let accelerations = motion.acceleration(&self.x);
        let result = impulses(&part, &opening, &restitution, scale);
        // Stops that take no part do not keep those that do from sharing what they give in any way.
        let pushing = touching.iter().zip(&result.impulses);
        let pushing: Vec<usize> = pushing
            .filter(|(_, p)| **p > Dd::ZERO)
            .map(|(&i, _)| i)
            .collect();
        if self.model.reactions_differ(&pushing) {
            self.doubt(AMBIGUOUS);
        }
        if let Some(reason) = result.doubt {
            self.doubt(reason);
            if result.opening.iter().any(|s| s.to_f64() < -CLOSED * scale) {
                return self.stop(reason);
            }
        }
        self.push(touching, &result.impulses);
        let mut hit = Vec::new();
        // Impulses of so small a part of the largest, in what they do to their gaps, are no impacts.
        let kick = |k: usize| (part.rows[k][k] * result.impulses[k]).to_f64();
        let least = NO_IMPACT * (0..touching.len()).map(kick).fold(0.0, f64::max);
        for (k, &i) in touching.iter().enumerate() {
            if result.impulses[k] > Dd::ZERO && kick(k) > least {
                self.near_coincidence(i);
                hit.push(i);
                self.record.hits.push(Hit {
                    time: self.time,
                    stop: i,
                    approach: -opening[k].to_f64(),
                    departure: result.opening[k].to_f64(),
                    impulse: result.impulses[k].to_f64(),
                    curvature: -dot(&self.model.stops[i].normal, &accelerations).to_f64(),
                    rounds: if result.is_shared { 0 } else { result.rounds },
                });
            }
        }
        let mut stays = Vec::new();
        for (k, &i) in touching.iter().enumerate() {
            let is_approached = opening[k] < Dd::ZERO && restitution[k] > 0.0;
            let is_slow = -opening[k].to_f64() < 1e-13 * scale;
            self.faded[i] = is_approached && is_slow && result.opening[k] == Dd::ZERO;
            if result.opening[k].to_f64() > 0.0 {
                self.leave(i, 1);
            } else {
                stays.push(i);
            }
        }
        self.settle(&stays);
        if let [stop] = hit[..]
            && self.contacts[stop] == Contact::Leaving(1)
        {
            self.complete(stop);
        }
    }

    /// The opening speed; at the start what is zero but for the rounding of the velocity given is zero.
    pub fn opening_at_contact(&self, stop: usize) -> Dd {
        let opening = self.model.opening(stop, &self.x);
        let terms = self.model.stops[stop]
            .normal
            .iter()
            .zip(&self.x[self.model.n..]);
        let size: f64 = terms.map(|(n, v)| (*n * *v).abs().to_f64()).sum();
        let is_rounding = self.time == Dd::ZERO && opening.abs().to_f64() <= 1e-15 * size;
        if is_rounding { Dd::ZERO } else { opening }
    }

    /// Stops that depend on each other and are hit almost together: their order is one of rounding.
    pub fn near_coincidence(&mut self, stop: usize) {
        let g = &self.model.delassus;
        let near = self
            .record
            .hits
            .iter()
            .rev()
            .take_while(|hit| ((self.time - hit.time).to_f64() * self.model.rate) < 1e-10);
        let is_near = near.into_iter().any(|hit| {
            let j = hit.stop;
            j != stop
                && hit.time != self.time
                && (g.rows[stop][j] != Dd::ZERO || g.rows[j][stop] != Dd::ZERO)
        });
        if is_near {
            self.doubt("two stops hit almost together");
        }
    }

    pub fn leave(&mut self, stop: usize, order: usize) {
        if let Some(start) = self.since[stop].take() {
            self.record.sticks.push(Stretch {
                stop,
                start: start.to_f64(),
                end: self.time.to_f64(),
            });
        }
        self.contacts[stop] = Contact::Leaving(order);
    }

    /// Which of the stops in contact with no normal speed stay, by the signs of forces and accelerations just ahead.
    pub fn settle(&mut self, stays: &[usize]) {
        if self.model.reactions_differ(stays) {
            self.doubt(AMBIGUOUS);
        }
        let delassus = self.model.delassus.part(stays);
        let ahead = Dd::from(AHEAD * self.model.step);
        let mut held: Vec<usize> = stays
            .iter()
            .copied()
            .filter(|i| self.held.contains(i))
            .collect();
        let mut is_settled = false;
        for _ in 0..12 {
            let Some(motion) = self.motion(&held) else {
                held.clear();
                continue;
            };
            let y = motion.advance(&self.x, ahead);
            let free = self.model.free.times(&y);
            let pull: Vec<Dd> = stays
                .iter()
                .map(|&i| dot(&self.model.stops[i].normal, &free))
                .collect();
            let scale = free.iter().map(|a| a.abs().to_f64()).fold(0.0, f64::max);
            let solutions = complementary(&delassus, &pull, scale);
            let Some(forces) = solutions.first() else {
                return self.stop("no contact forces solve the law");
            };
            let effect = delassus.times(forces);
            if are_several(&delassus, &solutions, scale) {
                self.doubt(SEVERAL);
            }
            let mut next = Vec::new();
            for (k, &i) in stays.iter().enumerate() {
                if forces[k] > Dd::ZERO {
                    next.push(i);
                }
            }
            for (k, &i) in stays.iter().enumerate() {
                let opens = (effect[k] - pull[k]).to_f64();
                if !next.contains(&i) && opens.abs() <= 1e-19 * scale {
                    let mut more = next.clone();
                    more.push(i);
                    more.sort_unstable();
                    if self.motion(&more).is_some() {
                        next = more;
                    }
                }
            }
            if next == held {
                is_settled = true;
                break;
            }
            held = next;
        }
        if !is_settled {
            return self.stop("contact forces do not settle");
        }
        self.held.clone_from(&held);
        let motion = self.motion(&held).expect("settled");
        let y = motion.advance(&self.x, ahead);
        let a = motion.acceleration(&y);
        let scale = self
            .model
            .free
            .times(&y)
            .iter()
            .map(|a| a.abs().to_f64())
            .fold(0.0, f64::max);
        if self.opens_first(stays, &held, scale) {
            self.doubt("a gap opens and closes at once");
        }
        for &i in stays {
            let opens = -dot(&self.model.stops[i].normal, &a).to_f64();
            if held.contains(&i) || opens.abs() <= 1e-19 * scale {
                self.since[i].get_or_insert(self.time);
                self.contacts[i] = Contact::Held;
            } else {
                let series = motion.gap_series(i, &self.x);
                let weight = |k: i32| series[k as usize].abs().to_f64() * AHEAD.powi(k);
                let order = (2..8)
                    .max_by(|&a, &b| weight(a).total_cmp(&weight(b)))
                    .expect("not empty") as usize;
                if series[order].to_f64() < 0.0 {
                    self.doubt("a gap opens and closes at once");
                }
                self.leave(i, order);
            }
        }
    }

    /// Whether the stops held now may be held in other ways too, of which a run took one: forces along other directions than
    /// those of inertia need not be unique.
    pub fn is_one_of_several(&self) -> bool {
        let stops = self.held_stops();
        let delassus = self.model.delassus.part(&stops);
        let places = 0..stops.len();
        let is_symmetric = places.clone().all(|i| {
            let differs = |j: usize| (delassus.rows[i][j] - delassus.rows[j][i]).abs().to_f64();
            let size = |j: usize| delassus.rows[i][j].abs().to_f64();
            places.clone().all(|j| differs(j) <= 1e-13 * size(j))
        });
        if is_symmetric {
            return false;
        }
        let free = self.model.free.times(&self.x);
        let scale = free.iter().map(|a| a.abs().to_f64()).fold(0.0, f64::max);
        let pull = stops
            .iter()
            .map(|&i| dot(&self.model.stops[i].normal, &free));
        let solutions = complementary(&delassus, &pull.collect::<Vec<_>>(), scale);
        are_several(&delassus, &solutions, scale)
    }

    /// Whether one of those that are pressed just ahead opens now: it has been open meanwhile.
    fn opens_first(&self, stays: &[usize], held: &[usize], scale: f64) -> bool {
        let delassus = self.model.delassus.part(stays);
        let free = self.model.free.times(&self.x);
        let pull: Vec<Dd> = stays
            .iter()
            .map(|&i| dot(&self.model.stops[i].normal, &free))
            .collect();
        complementary(&delassus, &pull, scale)
            .first()
            .is_some_and(|forces| {
                let effect = delassus.times(forces);
                let opens = |k: usize| (effect[k] - pull[k]).to_f64() > 1e-19 * scale;
                (0..stays.len()).any(|k| held.contains(&stays[k]) && opens(k))
            })
    }
}
