//! Who hears how far long work is.

/// Hears how far long work is, from any thread; `()` hears nothing.
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
