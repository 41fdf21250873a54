//! Names of scenes as Rust identifiers.

use proc_macro2::Ident;
use quote::format_ident;

/// A name of the scene as a Rust identifier.
pub fn ident(name: &str) -> Ident {
    match syn::parse_str::<Ident>(name) {
        // As patterns these would denote constants.
        Ok(_) if ["None", "Some", "Ok", "Err", "DESCRIPTION", "SOURCE", "TAPE"].contains(&name) => {
            format_ident!("{name}_")
        }
        // A keyword since edition 2024.
        Ok(_) if name == "gen" => format_ident!("r#gen"),
        Ok(_) => format_ident!("{name}"),
        Err(_) if ["self", "Self", "super", "crate"].contains(&name) => format_ident!("{name}_"),
        Err(_) => format_ident!("r#{name}"),
    }
}

/// Whether a name is a valid Rust identifier without changes.
pub fn is_identifier(name: &str) -> bool {
    syn::parse_str::<Ident>(name).is_ok()
}
