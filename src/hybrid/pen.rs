//! Numbers put down in an order and taken up again in the same one, by one function for both: so a run is kept from which another goes on.

/// What puts numbers down, or takes them up.
pub(crate) enum Pen {
    /// It puts them down.
    Writes(Vec<f64>),
    /// It takes up those that are left; nothing where they were not those that were put down.
    Reads(Option<std::vec::IntoIter<f64>>),
}

impl Pen {
    /// One that takes up what was put down.
    pub fn reading(numbers: Vec<f64>) -> Self {
        Self::Reads(Some(numbers.into_iter()))
    }

    /// What was put down.
    pub fn written(self) -> Vec<f64> {
        match self {
            Self::Writes(numbers) => numbers,
            Self::Reads(_) => Vec::new(),
        }
    }

    /// Whether all has been taken up that was put down, and no more.
    pub fn is_at_end(&self) -> bool {
        matches!(self, Self::Reads(Some(left)) if left.len() == 0)
    }

    /// Finds that the numbers were not put down so.
    pub fn lose(&mut self) {
        if let Self::Reads(left) = self {
            *left = None;
        }
    }

    /// How many numbers are left to be taken up.
    fn left(&self) -> usize {
        match self {
            Self::Reads(Some(left)) => left.len(),
            _ => 0,
        }
    }

    pub fn number(&mut self, own: &mut f64) {
        match self {
            Self::Writes(numbers) => numbers.push(*own),
            Self::Reads(Some(left)) if left.len() > 0 => *own = left.next().unwrap_or(0.0),
            Self::Reads(left) => *left = None,
        }
    }

    /// A count, which every double of its size is exactly.
    pub fn count(&mut self, own: &mut usize) {
        let mut number = *own as f64;
        self.number(&mut number);
        *own = number as usize;
        if *own as f64 != number {
            self.lose();
        }
    }

    /// As many things as there are, each of one number or more.
    pub fn list<T: Default + Clone>(
        &mut self,
        all: &mut Vec<T>,
        mut each: impl FnMut(&mut Self, &mut T),
    ) {
        let mut count = all.len();
        self.count(&mut count);
        if let Self::Reads(_) = self {
            if count > self.left() {
                self.lose();
                count = 0;
            }
            all.clear();
            all.resize(count, T::default());
        }
        for own in all {
            each(self, own);
        }
    }

    pub fn numbers(&mut self, all: &mut Vec<f64>) {
        self.list(all, Self::number);
    }

    pub fn counts(&mut self, all: &mut Vec<usize>) {
        self.list(all, Self::count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some numbers, carried.
    fn carry(pen: &mut Pen, (a, b, c): &mut (f64, Vec<usize>, Vec<[f64; 2]>)) {
        pen.number(a);
        pen.counts(b);
        pen.list(c, |pen, [x, y]| {
            pen.number(x);
            pen.number(y);
        });
    }

    #[test]
    fn what_is_put_down_is_taken_up() {
        let mut kept = (-0.0, vec![3, 0, 1 << 40], vec![[1.5, f64::INFINITY]]);
        let mut pen = Pen::Writes(Vec::new());
        carry(&mut pen, &mut kept);
        let numbers = pen.written();
        let taken = |numbers: &[f64]| {
            let (mut pen, mut taken) = (Pen::reading(numbers.to_vec()), (7.0, vec![9], Vec::new()));
            carry(&mut pen, &mut taken);
            pen.is_at_end().then_some(taken)
        };
        let again = taken(&numbers).expect("what was put down");
        assert_eq!(again, kept);
        assert!(again.0.is_sign_negative());
        // One number less, one more, a count that is none, a length beyond what is there.
        assert_eq!(taken(&numbers[1..]), None);
        assert_eq!(taken(&[&numbers[..], &[0.0]].concat()), None);
        for spoilt in [0.5, -1.0, f64::NAN, 1e300] {
            for place in [1, 3, 5] {
                let mut other = numbers.clone();
                other[place] = spoilt;
                assert_eq!(taken(&other), None, "{spoilt} {place}");
            }
        }
    }
}
