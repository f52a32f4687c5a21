//! Operators in exported text, and the text in which any one of them can be flipped when it runs.

use std::ops::Range;

/// What stands instead of an operator that is flipped; one of them where there are several.
const FLIPPED: [(&str, &[&str]); 12] = [
    ("+", &["-"]),
    ("-", &["+"]),
    ("*", &["+"]),
    ("&", &["|"]),
    ("|", &["&"]),
    ("^", &["|"]),
    ("&&", &["||"]),
    ("||", &["&&"]),
    ("==", &["!="]),
    ("<", &["<=", ">"]),
    ("<<", &[">>"]),
    (">>", &["<<"]),
];

/// A module's register that says which of its operators is flipped: none at 0.
const CHOICE: &str = "
  reg [15:0] flip;
  initial if (!$value$plusargs(\"flip=%d\", flip)) flip = 16'd0;
";

/// An operator that is to be flipped.
#[derive(Clone, Copy, Debug)]
pub struct Flip {
    /// Where it stands in the text.
    pub at: usize,
    /// The operator.
    pub right: &'static str,
    /// What stands there instead.
    pub wrong: &'static str,
}

/// Stands for an operator until its operands are known.
const MARK: char = '\u{1}';

/// Whether text beside an operator has a number of one bit next to it.
fn one_bit(side: &str) -> bool {
    ["1'd0", "1'd1"].iter().any(|n| side.starts_with(n) || side.ends_with(n))
}

/// Every way in which an operator of a module's text can be flipped.
pub fn flips(text: &str) -> Vec<Flip> {
    let mut found = vec![];
    let (mut from, mut function) = (0, false);
    for line in text.split_inclusive('\n') {
        let code = line.trim_start();
        function |= code.starts_with("function ");
        // What gathers unused signals and what counts zeros is the same in every module that has it.
        let passed = function || code.starts_with("//") || code.starts_with("wire unused ");
        function &= !code.starts_with("endfunction");
        for (k, _) in line.char_indices().filter(|_| !passed) {
            let token = line[k..].strip_prefix(' ').and_then(|rest| rest.split_once(' '));
            let Some((token, after)) = token else { continue };
            let flipped = FLIPPED.iter().find(|(right, _)| token == *right);
            let Some((right, wrong)) = flipped else { continue };
            // In one bit, one more is one less.
            if ["+", "-"].contains(right) && [&line[..k], after].iter().any(|side| one_bit(side)) {
                continue;
            }
            found.extend(wrong.iter().map(|wrong| Flip { at: from + k + 1, right, wrong }));
        }
        from += line.len();
    }
    found
}

/// The operands of what stands in `operator`, together with it: all between the parentheses, commas and the like
/// around it. No other operator stands beside it in exported text.
pub fn operation(text: &str, operator: &Range<usize>) -> Range<usize> {
    let edge = |chars: &mut dyn Iterator<Item = (usize, char)>, opens: &str, closes: &str| {
        let mut depth = 0;
        for (k, c) in chars {
            if depth == 0 && (closes.contains(c) || ",;?:=".contains(c)) {
                return Some(k);
            }
            depth += i32::from(opens.contains(c)) - i32::from(closes.contains(c));
        }
        None
    };
    let (before, after) = (&text[..operator.start], &text[operator.end..]);
    let start = edge(&mut before.char_indices().rev(), ")]}", "([{").map_or(0, |k| k + 1);
    let end = edge(&mut after.char_indices(), "([{", ")]}").unwrap_or(after.len());
    let trimmed = before[start..].trim_start().len();
    operator.start - trimmed..operator.end + after[..end].trim_end().len()
}

/// A module's text in which flip `k` of `flips` takes place if the simulator is called with `+flip=N`, N being what
/// stands beside it.
pub fn with_choice(text: &str, flips: &[(usize, Flip)]) -> String {
    let mut text = text.to_string();
    let mut last_first: Vec<_> = flips.to_vec();
    last_first.sort_by_key(|(_, flip)| std::cmp::Reverse(flip.at));
    for (number, Flip { at, right, .. }) in last_first {
        text.replace_range(at..at + right.len(), &format!("{MARK}{number}{MARK}"));
    }
    // An operand may hold other marks, which then stand in both of its copies.
    while let Some(start) = text.find(MARK) {
        let end = start + 1 + text[start + 1..].find(MARK).expect("marks stand on both sides") + 1;
        let number: usize = text[start + 1..end - 1].parse().expect("a number stands between");
        let (_, Flip { right, wrong, .. }) =
            flips.iter().find(|(n, _)| *n == number).expect("it is one of them");
        let whole = operation(&text, &(start..end));
        let (a, b) = (text[whole.start..start].trim_end(), text[end..whole.end].trim_start());
        let chosen = format!("(flip == 16'd{number} ? ({a} {wrong} {b}) : ({a} {right} {b}))");
        text.replace_range(whole, &chosen);
    }
    text.replacen("\n);\n", &format!("\n);{CHOICE}"), 1)
}

#[test]
fn an_operator_is_flipped_where_it_stands() {
    let text = "module m (\n  input a\n);\n  wire [3:0] n = (a && (b_q == 2'd1)) ? (c + 4'd1) :\n    c;\nendmodule\n";
    let all = flips(text);
    assert_eq!(all.iter().map(|flip| flip.right).collect::<Vec<_>>(), ["&&", "==", "+"]);
    let numbered: Vec<_> = (1..).zip(all).collect();
    let flipped = with_choice(text, &[numbered[0], numbered[1]]);
    let inner = "((flip == 16'd2 ? (b_q != 2'd1) : (b_q == 2'd1)))";
    let expected =
        format!("((flip == 16'd1 ? (a || {inner}) : (a && {inner}))) ? (c + 4'd1) :\n    c;");
    assert!(flipped.contains(&expected), "{flipped}");
}
