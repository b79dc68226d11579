//! The measuring eye: a picture in, corners out. It knows nothing of the simulator, so it works on a photograph too.
