//! Coefficients of the explicit Runge-Kutta method of order 8 of Dormand and Prince, "DOP853": Hairer, Norsett and Wanner,
//! Solving Ordinary Differential Equations I, sections II.5 (the method), II.10 (the errors) and II.6 (the dense output).

/// Stages of the solution; the one after them, number 13, is at its end and the first of the next step. [exact]
pub(crate) const DOP853_STAGES: usize = 12;
/// Stages with those that only the dense output needs. [exact]
pub(crate) const DOP853_ALL_STAGES: usize = 16;

/// Nodes of stages 2 to 16. [exact]
pub(crate) const DOP853_NODES: [f64; DOP853_ALL_STAGES - 1] = [
    0.052_600_151_958_767_73,
    0.078_900_227_938_151_6,
    0.118_350_341_907_227_4,
    0.281_649_658_092_772_6,
    1.0 / 3.0,
    0.25,
    4.0 / 13.0,
    127.0 / 195.0,
    0.6,
    6.0 / 7.0,
    1.0,
    1.0,
    0.1,
    0.2,
    7.0 / 9.0,
];

/// Rows of stages 2 to 16, each with a weight for every stage before; the row of stage 13 is the solution. [exact]
pub(crate) const DOP853_ROWS: [&[f64]; DOP853_ALL_STAGES - 1] = [
    &[0.052_600_151_958_767_73],
    &[0.019_725_056_984_537_9, 0.059_175_170_953_613_7],
    &[0.029_587_585_476_806_85, 0.0, 0.088_762_756_430_420_54],
    &[
        0.241_365_134_159_266_7,
        0.0,
        -0.884_549_479_328_286_1,
        0.924_834_003_261_792,
    ],
    &[
        1.0 / 27.0,
        0.0,
        0.0,
        0.170_828_608_729_473_86,
        0.125_467_687_566_822_42,
    ],
    &[
        19.0 / 512.0,
        0.0,
        0.0,
        0.170_252_211_019_544_05,
        0.060_216_538_980_455_96,
        -9.0 / 512.0,
    ],
    &[
        0.037_092_000_118_504_79,
        0.0,
        0.0,
        0.170_383_925_712_239_98,
        0.107_262_030_446_373_28,
        -0.015_319_437_748_624_402,
        0.008_273_789_163_814_023,
    ],
    &[
        0.624_110_958_716_075_7,
        0.0,
        0.0,
        -3.360_892_629_446_941_4,
        -0.868_219_346_841_726,
        27.592_099_699_446_71,
        20.154_067_550_477_894,
        -43.489_884_181_069_96,
    ],
    &[
        0.477_662_536_438_264_34,
        0.0,
        0.0,
        -2.488_114_619_971_667_7,
        -0.590_290_826_836_843,
        21.230_051_448_181_193,
        15.279_233_632_882_423,
        -33.288_210_968_984_86,
        -0.020_331_201_708_508_627,
    ],
    &[
        -0.937_142_430_085_987_3,
        0.0,
        0.0,
        5.186_372_428_844_064,
        1.091_437_348_996_729_5,
        -8.149_787_010_746_927,
        -18.520_065_659_996_96,
        22.739_487_099_350_505,
        2.493_605_552_679_652_3,
        -3.046_764_471_898_219_6,
    ],
    &[
        2.273_310_147_516_538,
        0.0,
        0.0,
        -10.534_495_466_737_25,
        -2.000_872_058_224_862_5,
        -17.958_931_863_118_8,
        27.948_884_529_419_96,
        -2.858_998_277_135_023_5,
        -8.872_856_933_530_63,
        12.360_567_175_794_303,
        0.643_392_746_015_763_6,
    ],
    &DOP853_SOLUTION,
    &[
        0.056_167_502_283_047_954,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
        0.253_500_210_216_624_83,
        -0.246_239_037_470_802_5,
        -0.124_191_423_263_816_37,
        0.153_291_798_278_765_68,
        0.008_201_052_295_634_69,
        0.007_567_897_660_545_699,
        -0.008_298,
    ],
    &[
        0.031_834_648_163_502_14,
        0.0,
        0.0,
        0.0,
        0.0,
        0.028_300_909_672_366_776,
        0.053_541_988_307_438_566,
        -0.054_923_748_571_390_99,
        0.0,
        0.0,
        -0.000_108_347_328_697_249_32,
        0.000_382_571_090_835_658_4,
        -0.000_340_465_008_687_404_56,
        0.141_312_443_674_632_5,
    ],
    &[
        -0.428_896_301_583_791_94,
        0.0,
        0.0,
        0.0,
        0.0,
        -4.697_621_415_361_164,
        7.683_421_196_062_599,
        4.068_989_818_397_11,
        0.356_727_187_455_281_1,
        0.0,
        0.0,
        0.0,
        -0.001_399_024_165_159_014_5,
        2.947_514_789_152_772_4,
        -9.150_958_472_179_87,
    ],
];

/// The solution, of order 8. [exact]
const DOP853_SOLUTION: [f64; DOP853_STAGES] = [
    0.054_293_734_116_568_765,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450_312_892_752_409,
    1.891_517_899_314_500_3,
    -5.801_203_960_010_585,
    0.311_164_366_957_819_9,
    -0.152_160_949_662_516_1,
    0.201_365_400_804_030_34,
    0.044_710_615_727_772_59,
];

/// The solution less one of order 5. [exact]
pub(crate) const DOP853_ERROR_5: [f64; DOP853_STAGES] = [
    0.013_120_044_994_194_88,
    0.0,
    0.0,
    0.0,
    0.0,
    -1.225_156_446_376_204_4,
    -0.495_758_949_657_250_2,
    1.664_377_182_454_986_4,
    -0.350_328_848_749_973_66,
    0.334_179_118_713_017_5,
    0.081_923_206_485_115_71,
    -0.022_355_307_863_886_294,
];

/// The solution less one of order 3, the quadrature on nodes 1, 9 and 12. [exact]
pub(crate) const DOP853_ERROR_3: [f64; DOP853_STAGES] = {
    let mut weights = DOP853_SOLUTION;
    weights[0] -= 31.0 / 127.0;
    weights[8] -= 12_675.0 / 17_272.0;
    weights[11] -= 3.0 / 136.0;
    weights
};

/// The last four coefficients of the dense output, of order 7. [exact]
pub(crate) const DOP853_DENSE: [[f64; DOP853_ALL_STAGES]; 4] = [
    [
        -8.428_938_276_109_013,
        0.0,
        0.0,
        0.0,
        0.0,
        0.566_714_953_519_377_7,
        -3.068_949_945_949_891_7,
        2.384_667_656_512_07,
        2.117_034_582_445_028,
        -0.871_391_583_777_973,
        2.240_437_430_260_788_3,
        0.631_578_778_769_468_8,
        -0.088_990_336_451_333_31,
        18.148_505_520_854_727,
        -9.194_632_392_478_356,
        -4.436_036_387_594_894,
    ],
    [
        10.427_508_642_579_134,
        0.0,
        0.0,
        0.0,
        0.0,
        242.283_491_775_258_17,
        165.200_451_717_270_28,
        -374.546_754_722_690_2,
        -22.113_666_853_125_306,
        7.733_432_668_472_264,
        -30.674_084_731_089_398,
        -9.332_130_526_430_229,
        15.697_238_121_770_845,
        -31.139_403_219_565_178,
        -9.352_924_358_844_48,
        35.816_841_486_394_08,
    ],
    [
        19.985_053_242_002_433,
        0.0,
        0.0,
        0.0,
        0.0,
        -387.037_308_749_351_8,
        -189.178_138_195_167_58,
        527.808_159_205_423_6,
        -11.573_902_539_959_63,
        6.881_232_694_696_3,
        -1.000_605_096_691_083_8,
        0.777_713_779_805_344_3,
        -2.778_205_752_353_508,
        -60.196_695_231_264_12,
        84.320_405_506_677_16,
        11.992_291_136_182_79,
    ],
    [
        -25.693_933_462_703_75,
        0.0,
        0.0,
        0.0,
        0.0,
        -154.189_748_690_236_43,
        -231.529_379_176_045_5,
        357.639_117_910_614_1,
        93.405_324_183_624_32,
        -37.458_323_136_451_63,
        104.099_649_508_962_3,
        29.840_293_426_660_5,
        -43.533_456_590_011_14,
        96.324_553_959_188_28,
        -39.177_261_675_615_44,
        -149.726_836_257_985_64,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    type Weights = [f64; DOP853_ALL_STAGES];

    /// An order condition: the weights that a rooted tree asks of a method add up to `1/density`.
    struct Tree {
        order: usize,
        weights: Weights,
        density: f64,
    }

    fn padded(weights: &[f64]) -> Weights {
        std::array::from_fn(|i| weights.get(i).copied().unwrap_or(0.0))
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// `sum_j a_ij x_j`
    fn through(x: &Weights) -> Weights {
        std::array::from_fn(|i| {
            if i == 0 {
                0.0
            } else {
                dot(DOP853_ROWS[i - 1], x)
            }
        })
    }

    /// The forests of some vertices in all, made of the trees from a first one on: products of their weights and densities.
    fn forests(trees: &[Tree], first: usize, vertices: usize) -> Vec<(Weights, f64)> {
        if vertices == 0 {
            return vec![([1.0; DOP853_ALL_STAGES], 1.0)];
        }
        let mut found = Vec::new();
        for (i, tree) in trees.iter().enumerate().skip(first) {
            if tree.order <= vertices {
                let branch = through(&tree.weights);
                for (others, density) in forests(trees, i, vertices - tree.order) {
                    let weights = std::array::from_fn(|k| branch[k] * others[k]);
                    found.push((weights, tree.density * density));
                }
            }
        }
        found
    }

    /// All rooted trees up to an order: a root that carries a forest of smaller ones.
    fn trees(largest: usize) -> Vec<Tree> {
        let mut trees = Vec::new();
        for order in 1..=largest {
            let forests = forests(&trees, 0, order - 1).into_iter();
            let rooted = forests.map(|(weights, density)| Tree {
                order,
                weights,
                density: order as f64 * density,
            });
            let rooted: Vec<_> = rooted.collect();
            trees.extend(rooted);
        }
        trees
    }

    /// The largest defect of some weights, meant for the part x of a step, in the conditions of one order.
    fn defect(weights: &Weights, trees: &[Tree], order: usize, x: f64) -> f64 {
        let power = (0..order).fold(1.0, |power, _| power * x);
        let of_order = trees.iter().filter(|tree| tree.order == order);
        of_order
            .map(|tree| (dot(weights, &tree.weights) - power / tree.density).abs())
            .fold(0.0, f64::max)
    }

    /// Weights of the dense output at the part x of a step.
    fn dense(x: f64) -> Weights {
        let (y, b) = (1.0 - x, padded(&DOP853_SOLUTION));
        std::array::from_fn(|i| {
            let (first, last) = (f64::from(i == 0), f64::from(i == DOP853_STAGES));
            let [c3, c4, c5, c6] = DOP853_DENSE.map(|weights| weights[i]);
            let (c0, c1, c2) = (b[i], first - b[i], 2.0 * b[i] - first - last);
            x * (c0 + y * (c1 + x * (c2 + y * (c3 + x * (c4 + y * (c5 + x * c6))))))
        })
    }

    #[test]
    fn rows_add_up_to_their_nodes() {
        for (row, node) in DOP853_ROWS.iter().zip(DOP853_NODES) {
            assert!((row.iter().sum::<f64>() - node).abs() < 1e-14, "{node}");
        }
        for (before, row) in DOP853_ROWS.iter().enumerate() {
            assert_eq!(row.len(), before + 1);
        }
    }

    #[test]
    fn rows_are_quadratures_of_their_stage_order() {
        // sum_j a_ij c_j^k = c_i^(k+1)/(k+1) from stage 6 on.
        let node = |i: usize| if i == 0 { 0.0 } else { DOP853_NODES[i - 1] };
        for i in 5..DOP853_ALL_STAGES {
            for k in 1..=if i < DOP853_STAGES { 4 } else { 5 } {
                let powers: Weights = std::array::from_fn(|j| node(j).powi(k));
                let exact = node(i).powi(k + 1) / f64::from(k + 1);
                assert!((through(&powers)[i] - exact).abs() < 1e-14, "{i} {k}");
            }
        }
    }

    #[test]
    fn the_solution_is_of_order_eight() {
        let (weights, trees) = (padded(&DOP853_SOLUTION), trees(9));
        assert_eq!(trees.len(), 486);
        for order in 1..=8 {
            assert!(defect(&weights, &trees, order, 1.0) < 1e-14, "{order}");
        }
        assert!(defect(&weights, &trees, 9, 1.0) > 1e-5);
    }

    #[test]
    fn the_errors_are_of_orders_five_and_three() {
        let trees = trees(6);
        for (weights, last) in [(DOP853_ERROR_5, 5), (DOP853_ERROR_3, 3)] {
            for order in 1..=last {
                assert!(
                    defect(&padded(&weights), &trees, order, 0.0) < 1e-14,
                    "{order}"
                );
            }
            assert!(defect(&padded(&weights), &trees, last + 1, 0.0) > 1e-4);
        }
    }

    #[test]
    fn the_dense_output_is_of_order_seven_at_every_point() {
        let trees = trees(8);
        for step in 1..10 {
            let x = f64::from(step) / 10.0;
            for order in 1..=7 {
                assert!(defect(&dense(x), &trees, order, x) < 1e-14, "{order} {x}");
            }
            assert!(defect(&dense(x), &trees, 8, x) > 1e-6);
        }
    }
}
