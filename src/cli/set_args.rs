//! The arguments that change the values of a scene.

use crate::scene::Override;

/// Values that take the place of those in a scene.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct SetArgs {
    /// Put this value in place of the one in the scene, as in `prism.index=1.5`, `prism.glass=N-BK7`, `board.position_mm[2]=800`; may be
    /// given more than once. Keys, units and rules are those of scene text; words need no quotes, and nothing behind `=` takes the key
    /// out.
    #[arg(long, value_name = "KEY=VALUE", value_parser = Override::of_words)]
    pub set: Vec<Override>,
}
