//! The equations of motion of a windscreen wiper, generated from `wiper.toml`.

#[cfg(feature = "generate")]
include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

#[cfg(not(feature = "generate"))]
include!("../generated/scenes.rs");

const _: () = assert!(
    wiper::DESCRIPTION.is_of(include_str!("../wiper.toml")),
    "generated/ is of another scene: build with the feature `generate`, or put wiper.toml back"
);
