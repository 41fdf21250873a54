//! A main file that calls all functions at states that it reads, and prints their results.

use super::states::fields;
use qrm_language::ir::{Function, Program, Shape, StructKind, Variable};

/// The text of the file.
pub(super) fn driver(program: &Program) -> String {
    let Program { name, coordinates, constraints, .. } = program;
    let mut text = format!("#include \"{name}.h\"\n\n#include <math.h>\n#include <stdio.h>\n\n");
    text += "static void print(const double *numbers, int count)\n{\n    for (int i = 0; i < count; i++) {\n        \
             printf(\"%.17g\\n\", numbers[i]);\n    }\n}\n\n";
    text += "static int scan(double *numbers, int count)\n{\n    for (int i = 0; i < count; i++) {\n        \
             if (scanf(\"%lf\", &numbers[i]) != 1) return 0;\n    }\n    return 1;\n}\n\nint main(void)\n{\n";
    text += &format!("    struct {name} m;\n    struct {name}_parameters replace;\n");
    let is_there = |kind: &StructKind| *kind == StructKind::Angles || program.has(*kind);
    for kind in [StructKind::Parameters, StructKind::Constants, StructKind::Position, StructKind::Angles]
        .into_iter()
        .filter(is_there)
    {
        text += &format!("    struct {name}_{} {};\n", kind.name(), variable(kind));
    }
    let arrays = [
        ("change", fields(program, StructKind::Parameters).len()),
        ("q", coordinates.len()),
        ("qd", coordinates.len()),
        ("qdd", coordinates.len()),
        ("multipliers", constraints.len()),
        ("residuals", constraints.len()),
    ];
    for (array, count) in arrays {
        text += &format!("    double {array}[{}] = {{0.0}};\n", count.max(1));
    }
    text += "    double t;\n    while (scan(&t, 1)";
    for (array, count) in arrays {
        text += &format!(" && scan({array}, {count})");
    }
    text += ") {\n";
    for function in &program.functions {
        text += &call(program, function);
    }
    text + "    }\n    return 0;\n}\n"
}

/// Calls a function and prints its results.
fn call(program: &Program, function: &Function) -> String {
    let name = &program.name;
    let mut arguments: Vec<String> = function.arguments.iter().map(argument).collect();
    if function.returns_scalar() {
        return format!(
            "        {{\n            double value = {name}_{}({});\n            print(&value, 1);\n        }}\n",
            function.name,
            arguments.join(", ")
        );
    }
    let (mut declared, mut printed) = (String::new(), String::new());
    for (i, result) in function.results.iter().enumerate() {
        let place = format!("r{i}");
        match result.shape {
            Shape::Scalar => {
                declared += &format!("            double {place};\n");
                printed += &format!("            print(&{place}, 1);\n");
                arguments.push(format!("&{place}"));
            }
            Shape::Vector(count) => {
                declared += &format!("            double {place}[{}];\n", count.max(1));
                printed += &format!("            print({place}, {count});\n");
                arguments.push(place);
            }
            Shape::Matrix(rows, columns) => {
                declared += &format!("            double {place}[{}][{columns}];\n", rows.max(1));
                printed += &format!("            print(&{place}[0][0], {rows} * {columns});\n");
                arguments.push(place);
            }
            Shape::Booleans(count) => {
                declared += &format!("            int {place}[{count}];\n");
                printed += &format!(
                    "            for (int i = 0; i < {count}; i++) {{\n                printf(\"%d\\n\", \
                     {place}[i]);\n            }}\n"
                );
                arguments.push(place);
            }
            Shape::Struct(kind) => {
                printed += &structure(program, function, kind);
                arguments.push(format!("&{}", variable(kind)));
            }
        }
    }
    format!(
        "        {{\n{declared}            {name}_{}({});\n{printed}        }}\n",
        function.name,
        arguments.join(", ")
    )
}

/// The code that fills a struct, prints its numbers, and uses parameters.
fn structure(program: &Program, function: &Function, kind: StructKind) -> String {
    let count = match kind {
        StructKind::Angles => 2 * program.coordinates.len(),
        _ => fields(program, kind).len(),
    };
    let print = format!("            print((const double *)&{}, {count});\n", variable(kind));
    let use_them = match function.name.as_str() {
        // Every second one is replaced.
        "default_parameters" => format!(
            "            for (int i = 0; i < {count}; i++) {{\n                ((double *)&replace)[i] = i % 2 ? NAN : \
             ((double *)&p)[i] + change[i];\n            }}\n"
        ),
        "parameters_with" => format!("            {}_new(&p, &m);\n", program.name),
        _ => String::new(),
    };
    [print, use_them].concat()
}

fn argument(argument: &Variable) -> String {
    match argument.shape {
        Shape::Struct(StructKind::Parameters) if argument.name != "p" => "&replace".to_owned(),
        Shape::Struct(kind) => format!("&{}", variable(kind)),
        _ => argument.name.clone(),
    }
}

fn variable(kind: StructKind) -> &'static str {
    match kind {
        StructKind::Mechanism => "m",
        StructKind::Parameters => "p",
        kind => kind.name(),
    }
}
