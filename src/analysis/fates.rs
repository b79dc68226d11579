//! How the rays of a picture ended.

use crate::optics::fate::Fate;
use crate::raster::Raster;
use crate::render::Class;
use std::collections::BTreeMap;

/// How the rays of the picture's pixels ended, those that met the board's plane left out.
pub fn fates(classes: &Raster<Class>) -> BTreeMap<&'static str, usize> {
    let count = |fate: Fate| classes.data().iter().filter(|&&c| c == Class::from(fate)).count();
    // Only scenes that ask for clipping know of it.
    let known = Fate::ALL.into_iter().filter(|&fate| fate != Fate::Clipped || count(fate) > 0);
    known.map(|fate| (fate.name(), count(fate))).collect()
}
