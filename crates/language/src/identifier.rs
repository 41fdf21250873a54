//! Names of scenes as identifiers of Rust.

use proc_macro2::Ident;
use quote::format_ident;

/// A name of the scene as a Rust identifier.
pub fn ident(name: &str) -> Ident {
    match syn::parse_str::<Ident>(name) {
        // As patterns these would mean a constant.
        Ok(_) if ["None", "Some", "Ok", "Err", "DESCRIPTION", "SOURCE", "TAPE"].contains(&name) => {
            format_ident!("{name}_")
        }
        // A word of the language since its edition of 2024.
        Ok(_) if name == "gen" => format_ident!("r#gen"),
        Ok(_) => format_ident!("{name}"),
        Err(_) if ["self", "Self", "super", "crate"].contains(&name) => format_ident!("{name}_"),
        Err(_) => format_ident!("r#{name}"),
    }
}

/// Whether a name is an identifier of Rust as it stands.
pub fn is_identifier(name: &str) -> bool {
    syn::parse_str::<Ident>(name).is_ok()
}
