//! The law of impact for stops that are held where another one is hit (theory 6, 9): they stay held if that needs no pulling impulse, and
//! they receive an impulse where they would be passed without.

use crate::error::Result;
use crate::impact::Impact;
use crate::law::Regime;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Rule};

/// The regimes before an instant and after it, its time and the impacts there.
#[derive(Debug, Clone, Copy)]
pub(in crate::orbit) struct HeldAtImpact<'a> {
    pub before: &'a Regime,
    pub after: &'a Regime,
    pub time: f64,
    pub impacts: &'a [Impact],
}

/// Judges stops that are held where others are hit. `speed_per_impulse` of two stops is what an impulse on the second one gives to the
/// opening speed of the first; speeds up to `slow` are none.
pub(in crate::orbit) fn judge_thrown(
    own: HeldAtImpact<'_>,
    speed_per_impulse: impl Fn(usize, usize) -> Result<f64>,
    slow: impl Fn(usize) -> f64,
    found: &mut Admissibility,
) -> Result<()> {
    let HeldAtImpact { before, time, .. } = own;
    let here = || own.impacts.iter().filter(|impact| impact.time == time);
    let is_struck = |stop: usize| here().any(|impact| impact.stop == stop);
    for &stop in before
        .constrained()
        .iter()
        .filter(|&&stop| !is_struck(stop))
    {
        let mut opening = 0.0;
        for impact in here() {
            opening += speed_per_impulse(stop, impact.stop)? * impact.impulse;
        }
        let rule = if opening > slow(stop) && !own.after.leaves_free(stop) {
            let impulse = -opening / speed_per_impulse(stop, stop)?;
            Rule::Pulls { impulse }
        } else if opening < -slow(stop) {
            Rule::Reached { approach: -opening }
        } else {
            continue;
        };
        found.keep_worst(Breach {
            stop,
            time,
            depth: 0.0,
            rule,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The verdict on stop 0, held before an impact on stop 1, that opens with some speed by the law.
    fn verdict(opening: f64, after: &[usize]) -> Option<Rule> {
        let impacts = [Impact {
            time: 2.0,
            stop: 1,
            approach: 1.0,
            departure: 0.5,
            impulse: 4.0,
            phase: 0.0,
        }];
        let own = HeldAtImpact {
            before: &Regime::holding([0]),
            after: &Regime::holding(after),
            time: 2.0,
            impacts: &impacts,
        };
        let mut found = Admissibility::default();
        let coupling =
            |one: usize, other: usize| Ok(if one == other { 2.0 } else { opening / 4.0 });
        judge_thrown(own, coupling, |_| 1e-9, &mut found).expect("no errors");
        found.breach.map(|breach| breach.rule)
    }

    #[test]
    fn what_is_thrown_off_is_not_held_and_what_is_pressed_takes_an_impulse() {
        assert_eq!(verdict(0.3, &[0]), Some(Rule::Pulls { impulse: -0.15 }));
        assert_eq!(verdict(0.3, &[]), None);
        assert_eq!(verdict(-0.3, &[0]), Some(Rule::Reached { approach: 0.3 }));
        assert_eq!(verdict(-0.3, &[]), Some(Rule::Reached { approach: 0.3 }));
        assert_eq!(verdict(1e-10, &[0]), None);
        assert_eq!(verdict(0.0, &[]), None);
    }
}
