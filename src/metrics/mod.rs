//! Points to numbers: how far a stereo pair is from ideal. Knows nothing of the simulator.
