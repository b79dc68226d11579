//! Designs that several scenes share, each made once.

use crate::design::{self, DesignInput};
use crate::effect::Effects;
use crate::error::Error;
use crate::scene::{PrismLaw, RevolvedSpec};
use crate::surface::shape::PolynomialPatch;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Designs that are kept, at most: some kilobytes each.
const MOST_DESIGNS: usize = 1024;

/// The polynomials of a design and the law of its halves, without its points.
#[derive(Debug, Clone)]
pub(super) struct DesignedPolynomials {
    pub(super) front: PolynomialPatch,
    pub(super) back: PolynomialPatch,
    pub(super) law: PrismLaw,
}

/// Designs that several scenes share: each is made once, whoever asks first, and others wait for it.
#[derive(Debug, Default)]
pub struct DesignStore {
    polynomials: Kept<DesignInput, DesignedPolynomials>,
    revolved: Kept<(DesignInput, Effects), RevolvedSpec>,
}

impl DesignStore {
    /// How many designs it has.
    pub fn count(&self) -> usize {
        self.polynomials.count() + self.revolved.count()
    }

    /// The polynomials of `input`.
    pub(super) fn polynomials(&self, input: &DesignInput) -> Result<DesignedPolynomials, Error> {
        self.polynomials.of(input, || {
            let designed = design::freeform(input)?;
            let law = designed.law();
            Ok(DesignedPolynomials { front: designed.front.patch, back: designed.back.patch, law })
        })
    }

    /// The surfaces of revolution of `input` with room for `effects`, which `make` makes.
    pub(super) fn revolved(
        &self,
        input: &DesignInput,
        effects: &Effects,
        make: impl FnOnce() -> Result<RevolvedSpec, Error>,
    ) -> Result<RevolvedSpec, Error> {
        self.revolved.of(&(*input, effects.clone()), make)
    }
}

/// What is made of a key, once; of the oldest keys nothing is kept.
#[derive(Debug)]
struct Kept<K, V>(Mutex<Vec<(K, Making<V>)>>);

/// What is made, or is being made.
type Making<V> = Arc<OnceLock<Result<V, Error>>>;

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: PartialEq + Clone, V: Clone> Kept<K, V> {
    fn of(&self, key: &K, make: impl FnOnce() -> Result<V, Error>) -> Result<V, Error> {
        let place = {
            let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let found = kept.iter().find(|(known, _)| known == key).map(|(_, place)| Arc::clone(place));
            found.unwrap_or_else(|| {
                if kept.len() == MOST_DESIGNS {
                    kept.remove(0);
                }
                let place = Arc::default();
                kept.push((key.clone(), Arc::clone(&place)));
                place
            })
        };
        // Others may ask for other keys meanwhile.
        place.get_or_init(make).clone()
    }

    fn count(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::system::System;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread::scope;

    /// What a host with threads of its own holds: it does not build where this is not so.
    #[test]
    fn instruments_go_between_threads() {
        fn both<T: Send + Sync + 'static>() {}
        both::<System>();
        both::<Scene>();
        both::<DesignStore>();
        both::<Error>();
    }

    #[test]
    fn each_key_is_made_once_whoever_asks() {
        let (kept, made) = (Kept::default(), AtomicUsize::new(0));
        let ask = |key: usize| {
            let make = || {
                made.fetch_add(1, Ordering::Relaxed);
                if key == 3 { Err(Error::new("three", "it cannot be", "ask for another")) } else { Ok(10 * key) }
            };
            kept.of(&key, make)
        };
        scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..8).for_each(|key| assert_eq!(ask(key).ok(), (key != 3).then_some(10 * key))));
            }
        });
        assert_eq!((made.load(Ordering::Relaxed), kept.count()), (8, 8));
        (8..MOST_DESIGNS + 8).for_each(|key| drop(ask(key)));
        assert_eq!(kept.count(), MOST_DESIGNS);
        ask(0).unwrap();
        assert_eq!(made.load(Ordering::Relaxed), MOST_DESIGNS + 9, "the oldest was given up");
    }
}
