//! `explain`: two runs side by side.

use super::*;

/// Two T-buffers of which one waits for a slow memory outside: what is told is what their reports say.
#[test]
fn what_differs_most_comes_first() {
    let folder = folder();
    for (out, sections) in [("a", "sections=1"), ("b", "sections=4096")] {
        let args = ["--scene", "glass", "-p", sections, "-p", "outside_latency=200", "--out", out];
        let further = ["-p", "reads_in_flight=2", "--no-wave", "--quiet"];
        exact(run(folder.path(), &[&args[..], &further].concat()));
    }
    let output = exact(pellucid(folder.path(), &["explain", "a", "b/stats.json"]));
    let text = stdout(&output);
    let [a, b] = ["a", "b"].map(|name| stats(&folder.path().join(name)));
    let resolve = |json: &Value| json["cycles"]["resolve"].as_i64().unwrap();
    let lines: Vec<Vec<&str>> =
        text.lines().map(|line| line.split_whitespace().collect()).collect();
    let after = |head: &str| {
        let at = lines.iter().position(|line| line.first() == Some(&head)).unwrap();
        lines[at + 1].clone()
    };
    let number = |text: &str| text.replace([',', '+'], "").parse::<i64>().unwrap();
    let most = after("CYCLES");
    assert_eq!(most[0], "resolve");
    assert_eq!(number(most[1]), resolve(&a));
    assert_eq!(number(most[2]), resolve(&b));
    assert_eq!(number(most[3]), resolve(&b) - resolve(&a));
    // The stream that stalls the most of all that differ.
    let stalls = |json: &Value, name: &str| {
        let streams = json["streams"].as_array().unwrap();
        streams.iter().find(|s| s["name"] == name).map_or(0, |s| s["stalls"].as_i64().unwrap())
    };
    let names = a["streams"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap());
    let largest = names.map(|name| (stalls(&b, name) - stalls(&a, name)).abs()).max().unwrap();
    assert_eq!(number(after("STALLS")[3]).abs(), largest);
    let share = stats(&folder.path().join("b"))["cycles"]["total"].as_f64().unwrap()
        / a["cycles"]["total"].as_f64().unwrap();
    assert!(text.contains(&format!(": {:.1} % fewer.", (1.0 - share) * 100.0)), "{text}");
}

#[test]
fn equal_runs_and_files_that_are_none() {
    let folder = folder();
    exact(run(folder.path(), &["--no-wave", "--quiet", "--out", "a"]));
    let output = exact(pellucid(folder.path(), &["explain", "a", "a"]));
    assert!(stdout(&output).contains("\nBoth take "), "{}", stdout(&output));
    assert!(!stdout(&output).contains("CYCLES"));
    refused(
        folder.path(),
        &["explain", "a", "no.json"],
        "cannot read `no.json`: No such file or directory",
    );
    fs::write(folder.path().join("x.json"), "{}").unwrap();
    refused(
        folder.path(),
        &["explain", "x.json", "a"],
        "`x.json` is no report: expected one that `pellucid run` or `explore` has left",
    );
    fs::write(folder.path().join("x.json"), "{").unwrap();
    let output = pellucid(folder.path(), &["explain", "x.json", "a"]);
    assert!(stderr(&output).starts_with("error: `x.json` is no JSON: "), "{}", stderr(&output));
}
