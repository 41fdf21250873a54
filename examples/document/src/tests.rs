//! The rows and errors against numbers that were measured before the algorithm became an example.

use qrm_model::quick_return::QuickReturn;

use crate::comparison::{Comparison, NAMES};
use crate::exact::EnergyIntegral;
use crate::motion::{Metric, Projection, Row, integrate};
use crate::write;

/// Rows of `qrm run quick-return --method document` when the command still had that method: their number, and the
/// values in the order of [`NAMES`].
const SCRIPT: [(usize, [f64; 17]); 4] = [
    (
        1,
        [
            0.007_852_505_773_582_983,
            7.851_029_935_128_596,
            -2.951_698_845_262_056_7,
            0.985_215_325_483_324_1,
            2.426_566_485_251_103,
            9.956_751_719_922_979,
            2.585_689_867_171_766,
            1.842_005_415_390_891_1,
            -1.248_195_594_743_518_6,
            -3_182.806_730_525_252,
            623.533_573_972_039_4,
            -0.120_780_193_377_606_15,
            -1.995_858_821_569_163,
            -6.024_092_447_071_162,
            1.304_363_152_490_439_8,
            -2_652.522_855_152_815_7,
            -623.533_573_972_039_4,
        ],
    ),
    (
        500,
        [
            3.602_119_026_064_244,
            6.807_880_257_021_940_6,
            0.285_382_133_814_344_74,
            2.274_506_384_188_425_7,
            1.184_065_142_104_231_2,
            -20.973_031_903_639_61,
            2.484_927_832_304_467,
            -1.128_541_919_477_331_6,
            17.368_312_897_070_933,
            768.370_097_638_917_9,
            957.118_127_299_336_8,
            -0.927_933_584_108_585_2,
            -0.221_627_686_926_017_9,
            6.120_370_829_307_822,
            -1.320_557_908_852_603_2,
            585.841_356_227_682,
            -957.118_127_299_336_8,
        ],
    ),
    (
        729,
        [
            5.098_498_124_757_881_6,
            7.470_290_015_459_508,
            27.623_336_907_584_285,
            0.989_857_706_999_380_2,
            -6.180_690_547_367_888,
            155.431_540_632_093_54,
            2.589_197_734_388_804,
            -4.648_762_882_629_743,
            57.863_532_613_906_61,
            -28_763.753_958_930_93,
            1_528.564_998_820_469_6,
            -0.131_732_871_196_548_08,
            5.136_871_352_248_657,
            -112.482_886_398_493_02,
            1.221_831_715_883_913_1,
            -24_044.999_586_073_136,
            -1_528.564_998_820_469_6,
        ],
    ),
    (
        1755,
        [
            12.558_560_104_841_852,
            7.856_916_546_273_618,
            -2.951_839_979_381_397,
            0.980_395_930_250_980_4,
            2.406_540_321_504_708_8,
            10.301_125_668_778_827,
            2.582_013_982_214_782_3,
            1.844_282_150_456_452_4,
            -0.815_993_951_486_002_3,
            -3_245.948_654_556_410_5,
            634.275_673_552_998_7,
            -0.116_818_027_353_537_25,
            -1.983_697_641_926_296_4,
            -6.410_911_645_438_056,
            1.314_767_293_890_203_7,
            -2_696.467_479_303_329_6,
            -634.275_673_552_998_7,
        ],
    ),
];

/// Rows of `qrm run quick-return`.
const COMMAND: [(usize, [f64; 17]); 4] = [
    (
        1,
        [
            0.007_852_505_773_595_312,
            7.851_029_935_129_088,
            -2.951_628_147_182_829_4,
            0.985_215_325_483_140_3,
            2.426_566_485_252_249_7,
            9.872_252_940_427_474,
            2.585_689_867_171_495_4,
            1.842_005_415_392_582_2,
            -1.353_819_891_025_995_3,
            -3_167.335_709_737_621,
            620.884_941_784_857_1,
            -0.122_776_052_198_982_36,
            -1.998_822_475_775_269_3,
            -5.879_336_746_942_442_5,
            1.301_740_827_641_180_6,
            -2_639.629_443_863_296_3,
            -620.884_941_784_857_1,
        ],
    ),
    (
        500,
        [
            3.602_119_026_063_434,
            6.807_880_256_948_862,
            0.290_135_503_068_123_36,
            2.274_506_384_185_200_2,
            1.184_065_142_076_221_4,
            -21.138_924_958_766_495,
            2.484_927_832_306_935_7,
            -1.128_541_919_444_199,
            17.591_434_978_337_603,
            790.319_626_197_172_3,
            960.811_495_644_744,
            -0.928_155_211_794_693_8,
            -0.218_580_241_873_713_83,
            6.078_860_337_293_19,
            -1.321_513_423_252_510_8,
            602.576_705_011_679_3,
            -960.811_495_644_744,
        ],
    ),
    (
        729,
        [
            5.098_498_125_045_515,
            7.470_290_018_032_701,
            27.293_442_382_811_51,
            0.989_857_706_761_401_4,
            -6.180_690_542_653_558,
            155.149_991_928_246_32,
            2.589_197_734_209_81,
            -4.648_762_881_281_935,
            59.608_279_611_042_285,
            -28_760.229_093_255_748,
            1_553.708_566_906_011_8,
            -0.126_595_999_648_689,
            5.080_314_786_124_981_6,
            -113.192_404_736_249_12,
            1.229_928_305_701_658_8,
            -24_042.052_978_274_132,
            -1_553.708_566_906_011_8,
        ],
    ),
    (
        1755,
        [
            12.558_560_105_126_36,
            7.856_916_546_156_358,
            -2.951_830_880_950_663_3,
            0.980_395_930_336_884_9,
            2.406_540_321_877_892_5,
            10.213_451_963_823_614,
            2.582_013_982_279_784_5,
            1.844_282_150_430_939,
            -0.926_335_228_067_378,
            -3_229.857_216_823_785_6,
            631.550_225_340_523_1,
            -0.118_801_725_066_120_41,
            -1.986_808_463_940_760_8,
            -6.171_394_693_612_476,
            1.312_168_745_115_134_7,
            -2_683.100_034_944_111_5,
            -631.550_225_340_523_1,
        ],
    ),
];

fn comparison(step: f64) -> Comparison {
    Comparison::new(&QuickReturn::default(), step).expect("a motion")
}

fn near(what: &str, value: f64, expected: f64, allowed: f64) {
    assert!((value - expected).abs() <= allowed, "{what} is {value:e}, not {expected:e}");
}

fn are_as_measured(rows: &[Row], measured: &[(usize, [f64; 17])]) {
    for (k, expected) in measured {
        near("t", rows[*k].t, 1e-3 * *k as f64, 1e-15);
        for ((name, value), expected) in NAMES.iter().zip(rows[*k].values()).zip(expected) {
            near(&format!("{name} of row {k}"), value, *expected, 1e-12 * expected.abs().max(10.0));
        }
    }
}

#[test]
fn rows_of_the_script_are_as_measured() {
    let comparison = comparison(1e-3);
    assert_eq!(comparison.script.len(), 1757);
    are_as_measured(&comparison.script, &SCRIPT);
}

#[test]
fn rows_of_the_command_are_as_measured() {
    let comparison = comparison(1e-3);
    assert_eq!(comparison.command.len(), comparison.script.len());
    are_as_measured(&comparison.command, &COMMAND);
}

/// The references are those of the scene, with 50 digits.
#[test]
fn the_exact_motion_is_exact() {
    let mechanism = QuickReturn::default();
    let integral = EnergyIntegral::new(&mechanism).expect("a start");
    let two_revolutions = 1.755_994_279_022_448_8;
    let rows = integral.rows([0.0, 0.5, two_revolutions].into_iter()).expect("rows");
    near("phi2 after two revolutions", rows[2].q[0], 4.0 * std::f64::consts::PI, 2e-14);
    let half = [3.602_119_026_059_78, 2.274_506_384_184_564_4, 2.484_927_832_307_542];
    let half_rates = [6.807_880_256_955_884, 1.184_065_142_088_816_7, -1.128_541_919_454_831];
    for i in 0..3 {
        near("an angle at 0.5 s", rows[1].q[i], half[i], 1e-14);
        near("a rate at 0.5 s", rows[1].qd[i], half_rates[i], 4e-14);
    }
    near("N3 at 0.5 s", rows[1].outputs[4], 602.576_704_996_570_9, 1e-11);
    near("N6 at 0.5 s", rows[1].outputs[5], -960.811_495_641_164_6, 1e-11);
}

/// Measured with the rows of `qrm run --method dop853 --tolerance 1e-14` as the exact ones.
#[test]
fn errors_are_as_measured() {
    let comparison = comparison(1e-3);
    let angles: &[&str] = &["phi2", "phi4", "phi5"];
    let rates: &[&str] = &["phi2_dot", "phi4_dot", "phi5_dot"];
    for (columns, value, script_error, command_error) in [
        (angles, 12.5664, 1.51213e-9, 1.06857e-9),
        (rates, 11.7933, 2.32422e-8, 1.56363e-8),
        (&["phi2_ddot"], 34.7242, 0.492818, 8.96684e-8),
        (&["phi4_ddot"], 156.485, 2.19783, 4.07103e-7),
        (&["phi5_ddot"], 172.241, 2.91393, 5.49163e-7),
        (&["lambda_slot"], 28763.4, 280.290, 5.30901e-5),
        (&["lambda_guide"], 2131.67, 36.2552, 6.92747e-6),
        (&["x6"], 0.932419, 0.00849115, 7.71932e-10),
        (&["x6_dot"], 8.49092, 0.0615926, 1.14506e-8),
        (&["x6_ddot"], 123.174, 5.65635, 3.62693e-7),
        (&["v_slide"], 1.6145, 0.0111792, 2.11533e-9),
        (&["N3"], 24357.7, 272.099, 4.79962e-5),
        (&["N6"], 2131.67, 36.2552, 6.92747e-6),
    ] {
        let largest = comparison.largest(columns);
        near(&format!("{columns:?}"), largest.value, value, 1e-3 * value);
        near(&format!("{columns:?}, script"), largest.script_error, script_error, 2e-4 * script_error);
        near(&format!("{columns:?}, qrm run"), largest.command_error, command_error, 2e-4 * command_error);
    }
}

#[test]
fn the_chapter_shows_the_table_that_is_printed() {
    let chapter = include_str!("../../../docs/the-document.md");
    let table = comparison(1e-3).table();
    assert!(chapter.contains(&format!("```text\n{table}```")), "the chapter should show\n{table}");
    assert!(table.lines().all(|line| line.len() <= 120), "{table}");
}

#[test]
fn derived_quantities_are_of_first_order() {
    let (coarse, fine) = (comparison(1e-3), comparison(5e-4));
    for name in NAMES {
        let ratio = |of: fn(&Comparison, &str) -> f64| of(&coarse, name) / of(&fine, name);
        let script = ratio(|comparison, name| comparison.largest(&[name]).script_error);
        let command = ratio(|comparison, name| comparison.largest(&[name]).command_error);
        let is_state = ["phi2", "phi4", "phi5", "phi2_dot", "phi4_dot", "phi5_dot"].contains(&name);
        let expected = if is_state { 8.5..9.5 } else { 1.95..2.05 };
        assert!(expected.contains(&script), "{name}, script: {script}");
        assert!((15.5..17.5).contains(&command), "{name}, qrm run: {command}");
    }
}

#[test]
fn a_hundredth_of_the_step_leaves_three_newtons() {
    let comparison = comparison(1e-5);
    near("lambda_slot", comparison.largest(&["lambda_slot"]).script_error, 2.80, 0.01);
    near("N3", comparison.largest(&["N3"]).script_error, 2.72, 0.01);
}

/// The metric is that of the script in both cases.
#[test]
fn the_closing_tolerance_ends_the_projection_too_early() {
    let mechanism = QuickReturn::default();
    let exact = comparison(5e-4).exact;
    let errors = |has_further_correction| {
        let projection = Projection { metric: Metric::Euclidean, has_further_correction };
        let states = integrate(&mechanism, 5e-4, projection).expect("a motion");
        let errors: Vec<f64> = states.iter().zip(&exact).map(|(s, exact)| (s.q - exact.q).amax()).collect();
        (errors[1000], errors.iter().copied().fold(0.0, f64::max))
    };
    let (at_half, largest) = errors(false);
    near("script at 0.5 s", at_half, 2.32e-12, 0.05e-12);
    near("script, largest", largest, 1.71e-10, 0.02e-10);
    let (at_half, largest) = errors(true);
    near("one correction more at 0.5 s", at_half, 1.9e-13, 0.5e-13);
    near("one correction more, largest", largest, 0.99e-10, 0.01e-10);
}

#[test]
fn ranges_of_the_chapter() {
    let exact = comparison(1e-3).exact;
    let most = |of: fn(&Row) -> f64| exact.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    near("largest v_slide", most(|row| row.outputs[3]), 1.6145, 5e-5);
    near("smallest v_slide", -most(|row| -row.outputs[3]), -1.3639, 5e-5);
    near("multiplier over force", most(|row| row.multipliers[0] / row.outputs[4]), 1.34, 5e-3);
    near("1/sin(phi4)", most(|row| row.q[1].sin().recip()), 1.34, 5e-3);
}

#[test]
fn the_file_has_each_column_beside_its_exact_values() {
    let comparison = comparison(1e-2);
    let mut csv = Vec::new();
    write(&comparison, &mut csv).expect("written");
    let csv = String::from_utf8(csv).expect("text");
    let lines: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), comparison.script.len() + 1);
    assert_eq!(lines[0][..5], ["t", "phi2", "phi2_exact", "phi2_dot", "phi2_dot_exact"]);
    let x6 = lines[0].iter().position(|name| *name == "x6").expect("a column");
    for (line, (script, exact)) in lines[1..].iter().zip(comparison.script.iter().zip(&comparison.exact)) {
        assert_eq!(line.len(), 35);
        let number = |i: usize| line[i].parse::<f64>().expect("a number");
        assert_eq!([number(0), number(x6), number(x6 + 1)], [script.t, script.outputs[0], exact.outputs[0]]);
    }
}
