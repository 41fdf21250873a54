//! `qrm live`: what it serves, and to whom.

use std::fs;
use std::io::{Read, Write};
use std::time::Instant;

use crate::common::live::Live;

#[test]
#[ignore = "full tier: engine"]
fn a_saved_scene_is_shown_anew() {
    let mut live = Live::of_scene("quick-return");
    let first = live.next_scene();
    assert_eq!((&first["problem"], &first["note"]), (&serde_json::Value::Null, &serde_json::Value::Null));
    live.edit("value = 0.2,", "value = 0.21,");
    let second = live.next_scene();
    live.edit("'C.y - yC'", "'C.y - yC + 0.001'");
    let third = live.next_scene();
    assert!(first["scene"] != second["scene"] && second["scene"] != third["scene"]);
    // Editors put a new file in the place of the old one.
    let other = live.folder().join("other");
    fs::write(&other, live.text().replacen("value = 0.7,", "value = 0.71,", 1)).expect("written");
    fs::rename(&other, live.file()).expect("moved");
    let fourth = live.next_scene();
    live.edit("value = 0.71,", "value = 0.7,");
    assert_eq!(live.next_scene()["scene"], third["scene"]);
    assert_ne!(fourth["scene"], third["scene"]);
}

#[test]
#[ignore = "full tier: engine"]
fn mistakes_are_shown_with_their_places() {
    let mut live = Live::of_scene("quick-return");
    live.next_scene();
    let text = live.text();
    live.save(text.replacen("'C.y - yC'", "'C.y - yD'", 1));
    let problem = live.wait_for_problem("unknown name `yD`");
    assert!(problem.contains("mine.toml:") && problem.contains("^^"), "{problem}");
    live.save(&text[..text.len() / 2]);
    live.wait_for_problem("error: ");
    let noise = |length: u32| (0..length).map(|i| i.wrapping_mul(2_654_435_761).to_be_bytes()[0]);
    for (text, expected) in [
        (noise(10_000_000).collect::<Vec<u8>>(), "it has more than 1000000 bytes"),
        (noise(1_000_000).collect(), "is not UTF-8 text"),
        (noise(1_000_000).map(|byte| b' ' + byte % 90).collect(), "not valid TOML here"),
        ("abc = 1\n".repeat(100_000).into_bytes(), "`abc` is written twice"),
    ] {
        live.save(text);
        assert!(live.wait_for_problem(expected).len() < 5000);
    }
    fs::remove_file(live.file()).expect("removed");
    live.wait_for_problem("there is no such file");
    fs::create_dir(live.file()).expect("a folder");
    live.wait_for_problem("it is a folder");
    fs::remove_dir(live.file()).expect("removed");
    live.save(text);
    assert_eq!(live.next_scene()["problem"], serde_json::Value::Null);
}

#[test]
#[ignore = "full tier: engine"]
fn a_text_that_is_whole_soon_is_no_mistake() {
    let mut live = Live::of_scene("quick-return");
    live.next_scene();
    let mut mistakes = 0;
    for number in 0..20 {
        let text = live.text();
        let text = format!("{}# {number}\n", text.split_inclusive("time = 10\n").next().expect("a scene"));
        live.save(&text[..text.len() / 3]);
        live.save(&text[..text.len() / 2]);
        live.save(&text);
        loop {
            let next = live.next();
            mistakes += usize::from(next["problem"].is_string());
            if next.get("scene").is_some() {
                break;
            }
        }
    }
    // On a machine with much to do, a save may take long.
    assert!(mistakes < 5, "{mistakes} mistakes in 20 saves");
}

/// A chain of pendulums whose linearization is derived for seconds.
fn chain(bodies: usize) -> String {
    let names = |of: &dyn Fn(usize) -> String| (0..bodies).map(of).collect::<Vec<_>>();
    let angle = |i: usize| (0..=i).map(|j| format!("a{j}")).collect::<Vec<_>>().join(" + ");
    let above = |i: usize, axis: &str| if i == 0 { String::new() } else { format!("P{}.{axis} + ", i - 1) };
    let point =
        |i: usize| format!("P{i} = ['{}cos({})', '{}sin({})']\n", above(i, "x"), angle(i), above(i, "y"), angle(i));
    format!(
        "name = \"chain\"\ncoordinates = [{}]\n[points]\n{}[bodies]\n{}[loads]\ngravity = {{ gravity = ['0', '-9.81'] \
         }}\n[initial]\ngiven = {{ {} }}\n[run]\nstep = 1e-3\nend_time = 1\nstiff = true\n\
         elimination = \"null-space\"\n",
        names(&|i| format!("{{ name = \"a{i}\", unit = \"rad\" }}")).join(", "),
        names(&point).concat(),
        names(&|i| format!("b{i} = {{ mass = 1, com = \"P{i}\" }}\n")).concat(),
        names(&|i| format!("a{i} = 0, a{i}_dot = 0")).join(", "),
    )
}

#[test]
#[ignore = "full tier: engine"]
fn the_next_save_cancels_a_long_derivation() {
    let mut live = Live::of_scene("quick-return");
    live.next_scene();
    let text = live.text();
    live.save(chain(20));
    // The first scene was shown before its functions were compared with its formulae: that may be cancelled too.
    while live.next()["note"] != "the scene is being derived; saving it again restarts that" {}
    let begun = Instant::now();
    live.save(format!("{text}# a text that was not derived yet\n"));
    let next = live.next();
    let note = next["note"].as_str().expect("a note").to_owned();
    assert!(note.starts_with("the derivation of the text before this one was cancelled after "), "{note}");
    live.next_scene();
    assert!(begun.elapsed().as_secs_f64() < 10.0, "the engine was not free: {:?}", begun.elapsed());
}

#[test]
#[ignore = "full tier: engine"]
fn a_killed_command_takes_its_engine_along() {
    let mut live = Live::of_text(&chain(12));
    assert!(live.next()["note"].is_string());
    let begun = Instant::now();
    live.kill();
    let mut other = Live::of_text(&format!("{}# another text\n", chain(2)));
    other.next_scene();
    assert!(begun.elapsed().as_secs_f64() < 10.0, "the engine was not free: {:?}", begun.elapsed());
    let cache = fs::read_dir(live.folder().join("cache")).expect("the cache");
    assert_eq!(cache.count(), 0, "it left files");
}

#[test]
#[ignore = "full tier: engine"]
fn values_are_written_to_the_file() {
    let mut live = Live::of_scene("quick-return");
    live.next_scene();
    let text = live.text();
    let (status, said) = live.post_values("O2A=0.25\nphi2=0.5");
    assert_eq!((status, said.as_str()), (200, "written to mine.toml"));
    live.next_scene();
    let expected = text.replacen("value = 0.2,", "value = 0.25,", 1).replacen("phi2 = 0,", "phi2 = 0.5,", 1);
    assert_eq!(live.text(), expected);
    for (values, said) in [
        ("O2B=0.25", "the file has no value for `O2B`"),
        ("O2A=0/0", "a line is no NAME=VALUE with a finite value"),
        ("O2A=inf", "a line is no NAME=VALUE with a finite value"),
        ("O2A", "a line is no NAME=VALUE with a finite value"),
    ] {
        assert_eq!(live.post_values(values).1, said);
    }
    let large = "the values take more than 65536 bytes: send fewer of them at once".to_owned();
    assert_eq!(live.post_values(&"O2A=0.25\n".repeat(10_000)), (413, large));
    live.save("name = ");
    assert_eq!(live.post_values("O2A=0.3").1, "the file is not valid TOML at present");
    assert_eq!(live.text(), "name = ");
}

#[test]
#[ignore = "full tier: engine"]
#[cfg(target_os = "linux")]
fn an_idle_session_rests() {
    let mut live = Live::of_scene("pendulum");
    live.next_scene();
    // User and system time of the process, in ticks of 0.01 s.
    let ticks = || -> f64 {
        let text = fs::read_to_string(format!("/proc/{}/stat", live.id())).expect("the process runs");
        let fields: Vec<&str> = text.rsplit(')').next().expect("fields").split_whitespace().collect();
        [11, 12].iter().map(|&place| fields[place].parse::<f64>().expect("a number")).sum()
    };
    let before = ticks();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let used = ticks() - before;
    assert!(used <= 20.0, "{used} of 200 ticks");
}

#[test]
fn only_its_own_page_is_answered() {
    let live = Live::of_scene("pendulum");
    let port = live.port();
    let (status, page) = live.get("", &[]);
    assert!(status == 200 && page.contains("qrm-panel"));
    assert_eq!(live.answer("GET", "/", &[], "").0, 404);
    assert_eq!(live.answer("GET", "/0123456789abcdef0123456789abcdef/", &[], "").0, 404);
    for path in ["mine.toml", "../mine.toml", "..%2f..%2fetc/passwd", "values", "cache/"] {
        assert_eq!(live.get(path, &[]).0, 404, "{path}");
    }
    assert_eq!(live.get("", &["Host: evil.example"]).0, 403);
    assert_eq!(live.get("", &[&format!("Host: evil.example:{port}")]).0, 403);
    assert_eq!(live.get("", &["Origin: http://evil.example"]).0, 403);
    assert_eq!(live.get("", &["Origin: null"]).0, 403);
    assert_eq!(live.get("", &[&format!("Host: localhost:{port}"), &format!("Origin: http://localhost:{port}")]).0, 200);
}

/// Requests that announce a body of any size take no memory for it, and no descriptor after their connection.
#[test]
#[cfg(unix)]
fn huge_requests_leave_nothing_behind() {
    let live = Live::with_descriptors(64);
    let (port, mut open) = (live.port(), Vec::new());
    for length in ["17000000", "99999999999", "18446744073709551615"].into_iter().cycle().take(60) {
        let mut stream = std::net::TcpStream::connect(format!("127.0.0.1:{port}")).expect("a connection");
        let request = format!("POST / HTTP/1.1\r\nHost: evil.example\r\nContent-Length: {length}\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("sent");
        open.push(stream);
    }
    assert_eq!(live.get("", &[]).0, 200);
    for mut stream in open {
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer and the end of the connection");
        assert!(answer.starts_with("HTTP/1.1 403 "), "{answer}");
    }
}

#[test]
fn what_cannot_be_served_is_said() {
    let live = Live::of_scene("pendulum");
    let said = live.refused(&["mine.toml", "--port", live.port()]);
    assert!(
        said.starts_with(&format!("error: port {} of the loopback interface cannot be taken: ", live.port())),
        "{said}"
    );
    let said = live.refused(&["yours.toml"]);
    assert!(said.contains("the scene cannot be read"), "{said}");
    let said = live.refused(&["pendulumm"]);
    assert!(said.contains("there is no scene `pendulumm`"), "{said}");
}

#[test]
#[cfg(target_os = "linux")]
fn the_address_of_the_command_line_works_once() {
    use std::os::unix::fs::PermissionsExt;
    // A browser that writes down what it is to open.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (browser, opened) = (folder.path().join("xdg-open"), folder.path().join("opened"));
    fs::write(&browser, format!("#!/bin/sh\necho \"$1\" > {0}.part; mv {0}.part {0}\n", opened.display()))
        .expect("written");
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).expect("a program");
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap_or_default());
    let live = Live::with_browser("pendulum", &path);
    let begun = Instant::now();
    while !opened.exists() && begun.elapsed().as_secs() < 10 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let address = fs::read_to_string(&opened).expect("an address");
    let path = format!("/{}", address.trim().rsplit('/').next().expect("a path"));
    assert!(!live.address.contains(&path));
    assert_eq!(live.answer("GET", &path, &["Host: evil.example"], "").0, 403);
    let (status, _) = live.answer("GET", &path, &[], "");
    assert_eq!(status, 303);
    assert_eq!(live.answer("GET", &path, &[], "").0, 404);
}

#[test]
#[ignore = "full tier: engine"]
fn two_sessions_follow_one_file() {
    let mut live = Live::of_scene("quick-return");
    let mut other = live.second();
    live.next_scene();
    other.next_scene();
    for number in 0..5 {
        live.save(format!("{}# {number}\n", live.text()));
        live.next_scene();
        other.next_scene();
    }
    // Both write.
    std::thread::scope(|scope| {
        for (place, writer) in [&live, &other].into_iter().enumerate() {
            scope.spawn(move || {
                for number in 0..20 {
                    let (status, _) = writer.post_values(&format!("O2A=0.2{place}{number:02}"));
                    // The other one may have saved just before.
                    assert!([200, 409].contains(&status), "{status}");
                }
            });
        }
    });
    assert_eq!(live.text().lines().filter(|line| line.starts_with("O2A ")).count(), 1);
    assert!(live.text().ends_with("# 4\n"));
}
