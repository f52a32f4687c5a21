use super::*;
use syn::parse_quote;

/// What is said of a function with this body.
fn refused(body: syn::Block) -> String {
    let item = parse_quote!(fn f(cfg: &Config, q: State, mut n: u32) -> u32 #body);
    match expand(Options::default(), item) {
        Ok(twins) => panic!("it was taken: {twins}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_has_no_netlist_form_is_refused_with_a_reason() {
    let cases: [(syn::Block, &str); 15] = [
        (
            parse_quote!({
                while n > 3 {
                    n -= 1;
                }
                n
            }),
            "hardware has no loop of unknown length: use `for` over a range of configuration",
        ),
        (
            parse_quote!({
                loop {
                    n -= 1;
                }
            }),
            "hardware has no loop of unknown length",
        ),
        (
            parse_quote!({ q.a / 3 }),
            "a divider is a block of its own: shift and mask for a power of two",
        ),
        (
            parse_quote!({
                n %= 3;
                n
            }),
            "a divider is a block of its own: shift and mask for a power of two",
        ),
        (
            parse_quote!({
                for _ in 0..q.a {
                    n += 1;
                }
                n
            }),
            "a loop is unrolled: its bounds are configuration, constants and literals",
        ),
        (
            parse_quote!({
                let f = |x| x + q.a;
                f(n)
            }),
            "a closure has no netlist form: use a function",
        ),
        (
            parse_quote!({
                if let 3 = q.a {
                    n = 1;
                }
                n
            }),
            "`if let` has no netlist form: use `match` or a flag",
        ),
        (
            parse_quote!({
                if q.b {
                    return 7;
                }
                n
            }),
            "a function ends at its end: write the rest as the other branch of an `if`",
        ),
        (
            parse_quote!({
                let x;
                x = n;
                x
            }),
            "a variable needs a value from the start",
        ),
        (
            parse_quote!({ q.a.count_ones() }),
            "hardware values do not have this method: use a function that is #[rtl] itself",
        ),
        (parse_quote!({ q.a as f32 }), "a hardware value is cast to u8, u16, u32, u64 or usize"),
        (parse_quote!({ -q.a }), "hardware integers are unsigned"),
        (parse_quote!({ Some(q.a) }), "a tuple constructor has no netlist form"),
        (
            parse_quote!({
                println!("{}", q.a);
                n
            }),
            "this macro has no netlist form",
        ),
        (
            parse_quote!({
                match q.a {
                    [1, ..] => 1,
                    _ => n,
                }
            }),
            "this pattern has no netlist form",
        ),
    ];
    for (body, reason) in cases {
        assert_eq!(refused(body), format!("#[rtl]: {reason}"));
    }
}

#[test]
fn functions_change_nothing_of_their_callers() {
    let item = parse_quote!(
        fn f(d: &mut State) {
            d.a = 1;
        }
    );
    let error = expand(Options::default(), item).unwrap_err().to_string();
    assert_eq!(
        error,
        "#[rtl]: a function gives its results back; it changes nothing of its caller"
    );
}

#[test]
fn a_block_says_how_it_is_checked() {
    let item = parse_quote!(impl Block for Store { type State = (); });
    let error = expand(Options::default(), item).unwrap_err().to_string();
    let expected = "#[rtl]: say with which configurations a test compares the netlist with the \
                    source: `check(TYPE, CONFIG)`";
    assert_eq!(error, expected);
}
