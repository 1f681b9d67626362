//! What the exponents of a motion say of it.

/// What a motion settles on, as far as its exponents tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attraction {
    /// An orbit, or rest: every deviation dies out but along the motion.
    Periodic,
    /// A torus: a direction across the motion in which deviations neither grow nor die out.
    Torus,
    /// Chaos: deviations grow.
    Chaotic,
    /// A drift: the motion repeats itself but for a constant advance, along which deviations neither grow nor die out.
    Drift,
    /// None of these, within the errors.
    Undecided,
}

impl Attraction {
    /// The name used in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::Torus => "torus",
            Self::Chaotic => "chaotic",
            Self::Drift => "drift",
            Self::Undecided => "undecided",
        }
    }
}

/// The kind of forcing of a motion, as far as it matters to exponents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ForcingKind {
    /// Nothing: along the motion deviations neither grow nor die out.
    None,
    /// Something of one period.
    Periodic,
    /// Tones without a common period.
    Tones,
    /// Signals.
    Signals,
}

/// The verdict on exponents, largest first, that are zero as far as anybody can tell within three errors, and within `least`.
pub(crate) fn verdict(
    exponents: &[f64],
    errors: &[f64],
    drive: ForcingKind,
    least: f64,
) -> Attraction {
    let sign = |i: usize| -> Option<i8> {
        if errors[i].is_nan() {
            return None;
        }
        let (value, bound) = (exponents[i], (3.0 * errors[i]).max(least));
        Some(if value > bound {
            1
        } else if value < -bound {
            -1
        } else {
            0
        })
    };
    let signs: Option<Vec<i8>> = (0..exponents.len()).map(sign).collect();
    let Some(mut signs) = signs else {
        return Attraction::Undecided;
    };
    if drive == ForcingKind::None
        && let Some(along) = signs.iter().position(|sign| *sign == 0)
    {
        signs.remove(along);
    }
    match (signs.first(), drive) {
        (Some(1), _) => Attraction::Chaotic,
        (Some(0), _) if signs[1..].iter().all(|sign| *sign < 0) => Attraction::Torus,
        (Some(-1) | None, ForcingKind::None | ForcingKind::Periodic) => Attraction::Periodic,
        (Some(-1), ForcingKind::Tones) => Attraction::Torus,
        _ => Attraction::Undecided,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_decide_within_errors() {
        let of = |exponents: &[f64], drive| {
            verdict(exponents, &vec![0.01; exponents.len()], drive, 1e-3)
        };
        assert_eq!(of(&[0.1, -0.3], ForcingKind::Periodic), Attraction::Chaotic);
        assert_eq!(
            of(&[-0.1, -0.3], ForcingKind::Periodic),
            Attraction::Periodic
        );
        assert_eq!(of(&[0.02, -0.3], ForcingKind::Periodic), Attraction::Torus);
        assert_eq!(
            of(&[0.02, 0.01], ForcingKind::Periodic),
            Attraction::Undecided
        );
        let none = f64::NEG_INFINITY;
        assert_eq!(
            of(&[none, none], ForcingKind::Periodic),
            Attraction::Periodic
        );
        assert_eq!(of(&[0.001, -0.3], ForcingKind::None), Attraction::Periodic);
        assert_eq!(of(&[-0.1, -0.3], ForcingKind::None), Attraction::Periodic);
        assert_eq!(
            of(&[0.2, 0.0, -0.3], ForcingKind::None),
            Attraction::Chaotic
        );
        assert_eq!(of(&[0.0, 0.0, -0.3], ForcingKind::None), Attraction::Torus);
        assert_eq!(of(&[0.0], ForcingKind::None), Attraction::Periodic);
        assert_eq!(of(&[-0.1, -0.3], ForcingKind::Tones), Attraction::Torus);
        assert_eq!(
            of(&[-0.1, -0.3], ForcingKind::Signals),
            Attraction::Undecided
        );
        assert_eq!(of(&[0.1, -0.3], ForcingKind::Signals), Attraction::Chaotic);
        let nan = [f64::NAN];
        assert_eq!(
            verdict(&[1.0], &nan, ForcingKind::Periodic, 1.0),
            Attraction::Undecided
        );
    }
}
