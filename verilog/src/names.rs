//! Names that Verilog takes.

use std::collections::HashSet;

/// The keywords of Verilog-2005 and those of SystemVerilog that tools know by default.
const KEYWORDS: &str = "\
    accept_on alias always always_comb always_ff always_latch and assert assign assume automatic \
    before begin bind bins binsof bit break buf bufif0 bufif1 byte case casex casez cell chandle \
    checker class clocking cmos config const constraint context continue cover covergroup \
    coverpoint cross deassign default defparam design disable dist do edge else end endcase \
    endchecker endclass endclocking endconfig endfunction endgenerate endgroup endinterface \
    endmodule endpackage endprimitive endprogram endproperty endsequence endspecify endtable \
    endtask enum event eventually expect export extends extern final first_match for force foreach \
    forever fork forkjoin function generate genvar global highz0 highz1 if iff ifnone ignore_bins \
    illegal_bins implements implies import incdir include initial inout input inside instance int \
    integer interconnect interface intersect join join_any join_none large let liblist library \
    local localparam logic longint macromodule matches medium modport module nand negedge nettype \
    new nexttime nmos nor noshowcancelled not notif0 notif1 null or output package packed \
    parameter pmos posedge primitive priority program property protected pull0 pull1 pulldown \
    pullup pulsestyle_ondetect pulsestyle_onevent pure rand randc randcase randsequence rcmos real \
    realtime ref reg reject_on release repeat restrict return rnmos rpmos rtran rtranif0 rtranif1 \
    s_always s_eventually s_nexttime s_until s_until_with scalared sequence shortint shortreal \
    showcancelled signed small soft solve specify specparam static string strong strong0 strong1 \
    struct super supply0 supply1 sync_accept_on sync_reject_on table tagged task this throughout \
    time timeprecision timeunit tran tranif0 tranif1 tri tri0 tri1 triand trior trireg type \
    typedef union unique unique0 unsigned until until_with untyped use uwire var vectored virtual \
    void wait wait_order wand weak weak0 weak1 while wildcard wire with within wor xnor xor";

/// A path of the Rust source as an identifier: `entries[3].z` as `entries_3_z`. A keyword gets an
/// underscore.
pub fn identifier(path: &str) -> String {
    let kept = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' };
    let mut name: String = path.replace(']', "").chars().map(kept).collect();
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
        name.insert(0, 'n');
    }
    if KEYWORDS.split_whitespace().any(|keyword| keyword == name) {
        name.push('_');
    }
    name
}

/// `FreeList` as `FREE_LIST`.
pub fn upper(name: &str) -> String {
    let mut text = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.extend(c.to_uppercase());
    }
    text
}

/// The names of one module, each given once.
#[derive(Debug, Default)]
pub struct Names(HashSet<String>);

impl Names {
    /// A name that is `wanted`, or has a number behind it if that is taken.
    pub fn unique(&mut self, wanted: &str) -> String {
        let wanted = identifier(wanted);
        let numbered = (2..).map(|k| format!("{wanted}_{k}"));
        let name = std::iter::once(wanted.clone()).chain(numbered).find(|n| !self.0.contains(n));
        let name = name.unwrap_or(wanted);
        self.0.insert(name.clone());
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_identifiers() {
        let names = ["entries[3].z", "release", "stage.payload.item", "table", "3d"];
        let expected = ["entries_3_z", "release_", "stage_payload_item", "table_", "n3d"];
        assert_eq!(names.map(identifier), expected);
    }

    #[test]
    fn keywords_are_sorted_and_single() {
        assert!(KEYWORDS.split_whitespace().is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn a_taken_name_gets_a_number() {
        let mut names = Names::default();
        assert_eq!(["x", "x", "x_2", "x"].map(|n| names.unique(n)), ["x", "x_2", "x_2_2", "x_3"]);
    }
}
