//! Generated programs.

use proptest::prelude::*;

/// A line made of pieces that mean something.
pub(crate) fn line() -> impl Strategy<Value = String> {
    const PIECES: &str = "G0|G1|G2|G3|G4|G17|G18|G19|G20|G21|G28|G43|G43.1|G49|G52|G53|G54|G59.3|G64|G80|G81|G83|G90|G91|G90.1|G92|G93|G94|\
        G41.1 D2|G42.1 D-1 L3|G42|G40|G5|G5.1|G5.2|G5.3|G7|G8|G33|G33.1|G38.2|G38.5|G76|G87|G96|G97|M19|M62|M66|M68|M70|M71|M72|M73|J-1|K0.5|E1|D9|\
        G98|G10 L2|L20|M2|M3|M6|M98|M99|X1|Y-2.5|Z[1/0]|I5|J0|K1|R3|P1|Q0.5|F100|S200|T1|H2|#1=2|#<a>=[#1+1]|X#<a>|Y##1|(msg,x)|(|;c|\
        o1 sub|o1 endsub|o1 call [1]|o2 if [#1 gt 0]|o2 endif|o2 else|o3 while [#1 lt 5]|o3 endwhile|o4 repeat [3]|o4 endrepeat|o3 break|\
        o5 do|o5 while [0]|o1|A90|1e3|%|/|N5|$1|@3|^45|[|]|**|--3|ATAN[1]/[2]|\u{e9}|\0";
    prop::collection::vec(
        prop::sample::select(PIECES.split('|').collect::<Vec<_>>()),
        0..5,
    )
    .prop_map(|pieces| pieces.join(" "))
}
