//! The examples at the end of each verb's help. They run from the folder that holds `scenes/` (and `golden/`).

macro_rules! examples {
    ($($name:ident: $first:literal $(, $more:literal)*;)*) => {
        $(pub(super) const $name: &str = concat!("Example:\n  ", $first $(, "\n  ", $more)*);)*
    };
}

examples! {
    MAIN: "biprism                                     # the design paper's prisms and the exact one, into out/",
        "biprism compare scenes/cases/prism_freeform.toml";
    COMPARE: "biprism compare scenes/cases/prism_freeform.toml --out out";
    NEW: "biprism new mine.toml --focal-mm 16 --pixel-um 3.75 --distance-mm 600";
    RENDER: "biprism render scenes/cases/prism_flat.toml --out picture.png --out picture.exr";
    CORNERS: "biprism render scenes/cases/prism_flat.toml --out picture.png",
        "biprism corners picture.png --out corners.csv";
    MEASURE: "biprism render scenes/cases/prism_flat.toml --out picture.exr",
        "biprism measure picture.exr --scene scenes/cases/prism_flat.toml --own --page page.html";
    DESIGN: "biprism design scenes/cases/prism_freeform.toml --objective toed-in --solid prism.stl";
    CHECK: "biprism check scenes/cases/prism_flat.toml";
    TRACE: "echo 20,30 | biprism trace scenes/cases/prism_flat.toml";
    RECTIFY: "biprism rectify scenes/cases/prism_flat.toml --depth-mm 700 --out maps";
    EXPORT: "biprism export scenes/cases/prism_freeform.toml --format stl --out prism.stl",
        "biprism export scenes/cases/prism_freeform.toml --format zemax-grid --out grids";
    DATASET: "biprism dataset scenes/cases/prism_flat.toml --poses 2 --noise 0:0.01 --out set";
    ANALYSE: "biprism analyse layout scenes/cases/prism_flat.toml --out out";
    BATCH: "biprism batch scenes/cases/prism_flat.toml --verb \"analyse reprojection\" --sweep prism.index=1.46:1.5:3 --out r.jsonl";
    MERGE: "biprism batch scenes/cases/prism_flat.toml --verb render --sweep prism.index=1.46:1.5:4 --shard 1/2 --out 1.jsonl",
        "biprism batch scenes/cases/prism_flat.toml --verb render --sweep prism.index=1.46:1.5:4 --shard 2/2 --out 2.jsonl",
        "biprism merge 1.jsonl 2.jsonl --figure counts/rays",
        "biprism analyse tolerance scenes/cases/prism_flat.toml --criterion vertical_px --trials 4 --shard 1/2 --out one",
        "biprism analyse tolerance scenes/cases/prism_flat.toml --criterion vertical_px --trials 4 --shard 2/2 --out two",
        "biprism merge one/tolerance_trials_*.jsonl two/tolerance_trials_*.jsonl";
    COST: "biprism cost scenes/cases/sensor_tiny.toml --quick --repetitions 1";
    GOLDEN: "biprism golden --only prism_flat";
    COMPLETIONS: "biprism completions bash > biprism.bash      # then: source biprism.bash";
    MAN: "biprism man --out man                        # then: man -l man/biprism-render.1";
    STABILITY: "biprism analyse stability --only parallel";
    SPOT: "biprism analyse spot scenes/cases/prism_freeform.toml";
    FIELD_CURVATURE: "biprism analyse field-curvature scenes/cases/prism_freeform.toml";
    MTF: "biprism analyse mtf scenes/cases/prism_flat.toml --na 0.05";
    REPROJECTION: "biprism analyse reprojection scenes/cases/prism_freeform.toml --depth-mm 1000";
    CONVERGENCE: "biprism analyse convergence scenes/cases/prism_freeform.toml --finest-um 80";
    TOLERANCE: "biprism analyse tolerance scenes/cases/prism_flat.toml --criterion vertical_px --budget vertical_px=0.1";
    SURFACE: "biprism analyse surface scenes/cases/prism_freeform.toml";
    PAPER: "biprism analyse paper --finest-um 80 --out paper";
    STEREO: "biprism analyse stereo scenes/cases/prism_flat.toml";
    LAYOUT: "biprism analyse layout scenes/cases/prism_flat.toml";
}
