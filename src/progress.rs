//! Who hears how far long work is.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Hears how far long work is, from any thread; `()` hears nothing. One that unwinds ends the work: it is told of 0 pixels before each
/// part of a picture.
pub trait Observer: Sync {
    /// The stage `name` begins.
    fn stage(&self, name: &'static str);
    /// The stage `name`, of `steps` steps, begins.
    fn stage_of(&self, name: &'static str, steps: usize);
    /// So many more pixels are done, or steps of a stage that has steps.
    fn pixels(&self, count: usize);
}

impl Observer for () {
    fn stage(&self, _: &'static str) {}
    fn stage_of(&self, _: &'static str, _: usize) {}
    fn pixels(&self, _: usize) {}
}

/// An observer of work of `of` steps, which it tells another one as `pixels` pixels.
#[allow(missing_debug_implementations, reason = "an observer need not have one")]
pub(crate) struct Scaled<'a> {
    observer: &'a dyn Observer,
    pixels: usize,
    of: usize,
    heard: AtomicUsize,
}

impl<'a> Scaled<'a> {
    /// Tells `observer` of `pixels` pixels while it hears of `of` steps.
    pub(crate) fn new(observer: &'a dyn Observer, pixels: usize, of: usize) -> Self {
        Self { observer, pixels, of: of.max(1), heard: AtomicUsize::new(0) }
    }
}

impl Observer for Scaled<'_> {
    fn stage(&self, _: &'static str) {}
    fn stage_of(&self, _: &'static str, _: usize) {}
    fn pixels(&self, count: usize) {
        let before = self.heard.fetch_add(count, Ordering::Relaxed);
        let told = |steps: usize| (steps.min(self.of) as u128 * self.pixels as u128 / self.of as u128) as usize;
        self.observer.pixels(told(before.saturating_add(count)) - told(before));
    }
}

/// An observer that hands the pixels on to a function.
#[derive(Debug, Clone, Copy)]
pub struct OnPixels<F>(pub F);

impl<F: Fn(usize) + Sync> Observer for OnPixels<F> {
    fn stage(&self, _: &'static str) {}
    fn stage_of(&self, _: &'static str, _: usize) {}
    fn pixels(&self, count: usize) {
        self.0(count);
    }
}
