//! Parses a generated module into its intermediate representation.

mod documentation;
mod expression;
mod function;
mod quantities;
mod shape;

use std::collections::BTreeMap;

use syn::{Expr, ImplItem, ImplItemFn, Item, Member, Stmt};

use super::Untranslated;
use super::ir::{Builtin, Expression, Field, Function, Program, Shape, Statement, Struct, StructKind, Variable};
use documentation::documentation;
use quantities::quantities;
use shape::Sizes;

/// The syntax of a generated module, the comments of its statements included.
///
/// # Errors
/// The text is not Rust.
pub fn syntax(text: &str) -> syn::Result<syn::File> {
    // A parser keeps documentation alone.
    let line = |line: &str| match line.split_once("// ") {
        Some((indent, comment)) if !indent.is_empty() && indent.trim().is_empty() => format!("{indent}/// {comment}\n"),
        _ => format!("{line}\n"),
    };
    // Behind the functions stands the scene, in a literal.
    let (functions, rest) = text.split_at(text.find("pub const SOURCE").unwrap_or(text.len()));
    let functions: String = functions.lines().map(line).collect();
    syn::parse_file(&(functions + rest))
}

/// What the comment at the top of a module says of its operations, and of what was left out.
pub(super) fn notes(text: &str) -> Vec<String> {
    let comment = text.lines().map_while(|line| line.strip_prefix("//"));
    let notes = comment.map(|line| line.strip_prefix(' ').unwrap_or(line).to_owned());
    notes.skip_while(|line| line != "Operations:").collect()
}

/// The intermediate representation of a module.
pub(super) fn lower(name: &str, file: &syn::File) -> Result<Program, Untranslated> {
    let parser = Parser::new(file)?;
    let mut structs = Vec::new();
    let mut doc = Vec::new();
    let mut functions = Vec::new();
    for item in &file.items {
        match item {
            Item::Struct(structure) if structure.ident == parser.mechanism => doc = documentation(&structure.attrs),
            Item::Struct(structure) => structs.push(lower_struct(structure)?),
            Item::Fn(item) => {
                let mut function = parser.function(&item.sig, &item.block, &item.attrs)?;
                if let Some(method) = parser.method_of(&function.name) {
                    function.arguments = parser.arguments(&method.sig)?;
                }
                functions.push(function);
            }
            Item::Impl(_) | Item::Use(_) | Item::Const(_) | Item::Static(_) | Item::Macro(_) => {}
            other => return Err(Untranslated::new("the item", other)),
        }
    }
    let mut all_functions = parser.values()?;
    all_functions.append(&mut functions);
    let [coordinates, constraints, outputs] = quantities(file)?;
    let [has_angle, is_length] = [parser.booleans("has_angle")?, parser.booleans("is_length")?];
    let name = name.to_owned();
    Ok(Program {
        name,
        doc,
        notes: Vec::new(),
        coordinates,
        constraints,
        outputs,
        has_angle,
        is_length,
        structs,
        functions: all_functions,
    })
}

/// What functions are parsed with.
#[derive(Default)]
struct Parser<'f> {
    /// The struct that is the mechanism.
    mechanism: String,
    sizes: Sizes,
    /// The methods of the implementations of traits.
    methods: BTreeMap<String, &'f ImplItemFn>,
    /// The functions that make parameters and constants.
    constructors: BTreeMap<String, &'f ImplItemFn>,
}

impl<'f> Parser<'f> {
    fn new(file: &'f syn::File) -> Result<Self, Untranslated> {
        let mut parser = Self::default();
        for item in &file.items {
            let Item::Impl(block) = item else { continue };
            let owner = shape::last_segment(&block.self_ty)?.ident.to_string();
            let methods = block.items.iter().filter_map(|item| match item {
                ImplItem::Fn(method) => Some(method),
                _ => None,
            });
            let of = block.trait_.as_ref().and_then(|implemented| implemented.0.segments.last());
            match (owner.as_str(), of) {
                ("Parameters" | "Constants", None) => {
                    parser.constructors.extend(methods.map(|method| (owner.clone(), method)))
                }
                (_, Some(of)) if of.ident == "Kernel" || of.ident == "Equations" => {
                    parser.mechanism = owner;
                    parser.sizes = Sizes::of(of)?;
                    parser.methods.extend(methods.map(|method| (method.sig.ident.to_string(), method)));
                }
                _ => {}
            }
        }
        Ok(parser)
    }

    /// The functions that give parameters, constants, and what a run needs.
    fn values(&self) -> Result<Vec<Function>, Untranslated> {
        let mut functions = Vec::new();
        if let Some(constructor) = self.constructors.get("Parameters") {
            let mut with = self.constructor(StructKind::Parameters, constructor)?;
            with.name = "parameters_with".to_owned();
            with.doc = vec![
                "The scene's values, but for those that `replace` has in their place; the others of it are not a number."
                    .to_owned(),
                "What the scene computes from other values follows them.".to_owned(),
            ];
            functions.push(defaults(&with));
            functions.push(with);
        }
        if let Some(constructor) = self.constructors.get("Constants") {
            let mut constants = self.constructor(StructKind::Constants, constructor)?;
            constants.doc = vec!["The values that depend on parameters alone.".to_owned()];
            functions.push(constants);
        }
        for (name, doc) in [
            ("start", "The start of the motion: given values, and first guesses of the others."),
            ("schedule", "Step and end of the motion, in s."),
            (
                "event",
                "A value that rises through zero when the stop condition becomes true; minus infinity without one.",
            ),
        ] {
            let method = self.methods.get(name).ok_or_else(|| Untranslated(format!("a module without `{name}`")))?;
            let mut function = self.function(&method.sig, &method.block, &[])?;
            function.doc = vec![doc.to_owned()];
            functions.push(function);
        }
        functions.push(angles(&self.booleans("has_angle")?));
        Ok(functions)
    }

    /// The method that is nothing but this function. All mechanisms have it with the same arguments.
    fn method_of(&self, function: &str) -> Option<&ImplItemFn> {
        let method = self.methods.get(function)?;
        let is_this = |called: &Expr| matches!(called, Expr::Path(path) if path.path.is_ident(function));
        match &method.block.stmts[..] {
            [Stmt::Expr(Expr::Call(call), None)] if is_this(&call.func) => Some(method),
            _ => None,
        }
    }

    /// The booleans that a method gives.
    fn booleans(&self, name: &str) -> Result<Vec<bool>, Untranslated> {
        let method = self.methods.get(name).ok_or_else(|| Untranslated(format!("a module without `{name}`")))?;
        let [Stmt::Expr(Expr::Array(array), None)] = &method.block.stmts[..] else {
            return Err(Untranslated::new("the method", method));
        };
        let boolean = |value: &Expr| match value {
            Expr::Lit(syn::ExprLit { lit: syn::Lit::Bool(boolean), .. }) => Ok(boolean.value),
            other => Err(Untranslated::new("the boolean", other)),
        };
        array.elems.iter().map(boolean).collect()
    }
}

/// The function that gives the scene's values of parameters, none of them replaced.
fn defaults(with: &Function) -> Function {
    let own = |statement: &Statement| match statement {
        Statement::Let { name, value: Expression::Call(Builtin::ValueOr, values) } => {
            Statement::Let { name: name.clone(), value: values[1].clone() }
        }
        other => other.clone(),
    };
    Function {
        name: "default_parameters".to_owned(),
        doc: vec!["The scene's values.".to_owned()],
        arguments: Vec::new(),
        results: with.results.clone(),
        body: with.body.iter().map(own).collect(),
    }
}

/// The function that gives sines and cosines.
fn angles(is_angle: &[bool]) -> Function {
    let mut body = Vec::new();
    for (i, is_angle) in is_angle.iter().enumerate() {
        for (field, builtin) in [("sin", Builtin::Sin), ("cos", Builtin::Cos)] {
            let value = match is_angle {
                true => Expression::Call(builtin, vec![Expression::name("q").element(i)]),
                false => Expression::Number("0.0".to_owned()),
            };
            body.push(Statement::Assign { place: Expression::name("angles").field(field).element(i), value });
        }
    }
    let q = Variable { name: "q".to_owned(), shape: Shape::Vector(is_angle.len()) };
    let angles = Variable { name: "angles".to_owned(), shape: Shape::Struct(StructKind::Angles) };
    let doc = "Sines and cosines of the coordinates that are angles; zero in the places of others.";
    Function { name: "angles".to_owned(), doc: vec![doc.to_owned()], arguments: vec![q], results: vec![angles], body }
}

fn lower_struct(structure: &syn::ItemStruct) -> Result<Struct, Untranslated> {
    let kind =
        shape::struct_kind(&structure.ident.to_string()).ok_or_else(|| Untranslated::new("the struct", structure))?;
    let mut fields = Vec::new();
    for field in &structure.fields {
        let name = field.ident.as_ref().ok_or_else(|| Untranslated::new("the tuple struct", structure))?;
        // It mentions the type of numbers.
        if shape::last_segment(&field.ty)?.ident != "PhantomData" {
            fields.push(Field { name: expression::identifier(name), doc: documentation(&field.attrs) });
        }
    }
    Ok(Struct { kind, doc: documentation(&structure.attrs), fields })
}

/// The name of a field.
fn member(member: &Member) -> Result<String, Untranslated> {
    match member {
        Member::Named(name) => Ok(expression::identifier(name)),
        Member::Unnamed(_) => Err(Untranslated::new("the field", member)),
    }
}
