//! Every instruction set that this processor has against the scalar one, bit for bit, on values that break careless code.

mod bundle;
mod queries;
mod rays;

use sahl_math::Vec3;

use super::isa::{BundleRow, Interval, Isa, Lanes, Octant, Order, Pushed, Row, Task, Window};
use super::{BUNDLE_RAYS, Tier, WIDTH, dispatch};

/// A counter-based generator with a fixed seed: splitmix64 of Steele, Lea, Flood, 2014.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit as u64) as usize
    }

    /// Uniform in [−1, 1).
    fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    /// One of few numbers that meet each other often.
    fn on_grid(&mut self) -> f32 {
        self.below(9) as f32 * 0.5 - 2.0
    }

    fn vector(&mut self, mut coordinate: impl FnMut(&mut Self) -> f32) -> Vec3 {
        Vec3::new(coordinate(self), coordinate(self), coordinate(self))
    }

    /// Any bits at all, or one of [`NASTY`].
    fn nasty(&mut self) -> f32 {
        match self.below(3) {
            0 => NASTY[self.below(NASTY.len())],
            1 => f32::from_bits(self.bits() as u32),
            _ => self.signed(),
        }
    }
}

const NASTY: [f32; 25] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.5,
    0.333_333_34,
    16_777_216.0,
    -16_777_215.0,
    1e-20,
    -1e20,
    1e18,
    f32::EPSILON,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    f32::from_bits(1),
    f32::from_bits(0x8000_0001),
    f32::from_bits(0x007f_ffff),
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    f32::from_bits(0xffc0_0001),
    f32::from_bits(0x7fc1_2345),
    2.9e-39,
];

fn tiers() -> impl Iterator<Item = Tier> {
    Tier::ALL.into_iter().filter(|tier| tier.is_available())
}

/// The result of a task, which must be the same on every instruction set.
fn agreed<T: Task<Output: PartialEq + std::fmt::Debug> + Clone>(task: &T, context: &str) -> T::Output {
    let expected = dispatch(Tier::Scalar, task.clone());
    for tier in tiers() {
        let found = dispatch(tier, task.clone());
        assert!(
            found == expected,
            "{tier:?} differs from the specification: {found:?} for {expected:?}, {context}"
        );
    }
    expected
}

/// The bits of a computed number. Which NaN comes out of arithmetic is not specified.
fn bits(value: f32) -> u32 {
    if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() }
}

struct Name;

impl Task for Name {
    type Output = &'static str;

    fn run<I: Isa>(self, _isa: I) -> &'static str {
        std::any::type_name::<I>()
    }
}

#[test]
fn each_tier_runs_its_own_instruction_set() {
    let expected = [
        (Tier::Scalar, "Scalar"),
        (Tier::Sse2, "Sse2"),
        (Tier::Neon, "Neon"),
        (Tier::Avx2, "Avx2"),
        (Tier::Avx512, "Avx512"),
    ];
    for (tier, name) in expected {
        let run = dispatch(tier, Name);
        assert_eq!(run.ends_with(name), tier.is_available(), "{tier:?} runs {run}");
        assert!(tier.is_available() || run == dispatch(Tier::detect(), Name), "{tier:?} runs {run}");
    }
    assert!(Tier::detect().is_available());
    assert!(tiers().all(|tier| tier <= Tier::detect()));
    if cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) {
        assert!(tiers().count() >= 2, "there is nothing to compare");
    }
}

/// Operations that compute, of which NaN is any NaN, before those that choose and keep every bit.
const COMPUTED: usize = 4;
const OPERATIONS: usize = 9;

/// All operations by what they mean for one lane; `chosen` is the bit of the mask.
fn definition(a: f32, b: f32, chosen: bool) -> [f32; OPERATIONS] {
    [
        a + b,
        a - b,
        a * b,
        1.0 / a,
        if a < b { a } else { b },
        if a > b { a } else { b },
        f32::from_bits(a.to_bits() & 0x7fff_ffff),
        if chosen { a } else { b },
        b,
    ]
}

#[inline(always)]
fn operations<L: Lanes>(a: L, b: L, mask: u32) -> [L; OPERATIONS] {
    [a + b, a - b, a * b, a.reciprocal(), a.min(b), a.max(b), a.abs(), a.select(mask, b), b]
}

#[inline(always)]
fn comparisons<L: Lanes>(a: L, b: L) -> [u32; 3] {
    [a.less(b), a.less_or_equal(b), a.equal(b)]
}

/// What operations make of two bundles of numbers.
#[derive(Debug)]
struct Results {
    lanes: [BundleRow; OPERATIONS],
    comparisons: [u64; 3],
}

const NO_RESULTS: Results = Results { lanes: [BundleRow::splat(7.0); OPERATIONS], comparisons: [0; 3] };

#[derive(Clone, Copy)]
struct Operands<'a> {
    a: &'a BundleRow,
    b: &'a BundleRow,
    mask: u64,
}

/// On eight lanes.
struct Narrow<'a>(Operands<'a>);

impl Task for Narrow<'_> {
    type Output = Results;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Results {
        let mut results = NO_RESULTS;
        let Operands { a, b, mask } = self.0;
        for (row, (a, b)) in a.0.as_chunks().0.iter().zip(b.0.as_chunks().0).enumerate() {
            let (a, b) = (isa.load(&Row(*a)), isa.load_unaligned(b));
            let computed = operations(a, b, (mask >> (row * WIDTH)) as u32 & 0xff);
            for (rows, lanes) in results.lanes.iter_mut().zip(computed) {
                rows.0.as_chunks_mut().0[row] = lanes.to_array();
            }
            for (all, part) in results.comparisons.iter_mut().zip(comparisons(a, b)) {
                *all |= u64::from(part) << (row * WIDTH);
            }
        }
        results
    }
}

/// On as many lanes as the instruction set has.
struct Wide<'a>(Operands<'a>);

impl Task for Wide<'_> {
    type Output = Results;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Results {
        assert!(I::WIDE.is_multiple_of(WIDTH) && BUNDLE_RAYS.is_multiple_of(I::WIDE));
        let mut results = NO_RESULTS;
        let Operands { a, b, mask } = self.0;
        for group in 0..BUNDLE_RAYS / I::WIDE {
            let (a, b) = (isa.load_wide(a, group), isa.load_wide(b, group));
            let mask = (mask >> (group * I::WIDE)) as u32 & ((1 << I::WIDE) - 1);
            for (rows, lanes) in results.lanes.iter_mut().zip(operations(a, b, mask)) {
                isa.store_wide(lanes, rows, group);
            }
            for (all, part) in results.comparisons.iter_mut().zip(comparisons(a, b)) {
                *all |= u64::from(part) << (group * I::WIDE);
            }
        }
        results
    }
}

fn check_operations(a: &BundleRow, b: &BundleRow, mask: u64) {
    let operands = Operands { a, b, mask };
    for tier in tiers() {
        for results in [dispatch(tier, Narrow(operands)), dispatch(tier, Wide(operands))] {
            for place in 0..BUNDLE_RAYS {
                let (a, b) = (a.0[place], b.0[place]);
                let expected = definition(a, b, mask >> place & 1 == 1);
                for (operation, expected) in expected.into_iter().enumerate() {
                    let found = results.lanes[operation].0[place];
                    let same = if operation < COMPUTED {
                        bits(found) == bits(expected)
                    } else {
                        found.to_bits() == expected.to_bits()
                    };
                    assert!(same, "{tier:?}, operation {operation}: {found:e} of {a:e} and {b:e}");
                }
                let found = results.comparisons.map(|mask| mask >> place & 1 == 1);
                assert_eq!(found, [a < b, a <= b, a == b], "{tier:?}: {a:e} and {b:e}");
            }
        }
    }
}

#[derive(Clone)]
struct SwapHalves(Row);

impl Task for SwapHalves {
    type Output = [f32; WIDTH];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [f32; WIDTH] {
        isa.swap_halves(isa.load(&self.0)).to_array()
    }
}

#[test]
fn halves_are_swapped() {
    let swapped = agreed(&SwapHalves(Row([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])), "");
    assert_eq!(swapped, [4.0, 5.0, 6.0, 7.0, 0.0, 1.0, 2.0, 3.0]);
}

#[derive(Clone)]
struct Transpose([[f32; WIDTH]; WIDTH]);

impl Task for Transpose {
    type Output = [[f32; WIDTH]; WIDTH];

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        isa.transpose(self.0.map(|row| isa.load_unaligned(&row))).map(Lanes::to_array)
    }
}

#[test]
fn rows_become_lanes() {
    let number = |row: usize, lane: usize| (10 * row + lane) as f32;
    let rows = std::array::from_fn(|row| std::array::from_fn(|lane| number(row, lane)));
    let lanes = std::array::from_fn(|lane| std::array::from_fn(|row| number(row, lane)));
    assert_eq!(agreed(&Transpose(rows), ""), lanes);
}

fn row(mut lane: impl FnMut() -> f32) -> Row {
    Row(std::array::from_fn(|_| lane()))
}

fn bundle_row(mut lane: impl FnMut() -> f32) -> BundleRow {
    BundleRow(std::array::from_fn(|_| lane()))
}

#[test]
fn operations_are_those_of_single_numbers() {
    let mut pairs = NASTY.iter().flat_map(|&a| NASTY.iter().map(move |&b| (a, b))).peekable();
    let mut random = Random(1);
    while pairs.peek().is_some() {
        let (mut a, mut b) = (BundleRow::splat(0.0), BundleRow::splat(0.0));
        for (place, (left, right)) in pairs.by_ref().take(BUNDLE_RAYS).enumerate() {
            (a.0[place], b.0[place]) = (left, right);
        }
        check_operations(&a, &b, random.bits());
    }
    for _ in 0..2000 {
        let mask = random.bits();
        let (a, b) = (bundle_row(|| random.nasty()), bundle_row(|| random.nasty()));
        check_operations(&a, &b, mask);
    }
}

/// The least and the greatest lane, of each row and of each group of all lanes; and whether splatted lanes are equal.
#[derive(Clone, Copy)]
struct Extremes<'a>(&'a BundleRow);

impl Task for Extremes<'_> {
    type Output = (Vec<[f32; 2]>, [f32; 2]);

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let each = |row| [isa.load_unaligned(row).least(), isa.load_unaligned(row).greatest()];
        let rows = self.0.0.as_chunks().0.iter().map(each).collect();
        let [mut low, mut high] = [f32::INFINITY, f32::NEG_INFINITY];
        for group in 0..BUNDLE_RAYS / I::WIDE {
            let lanes = isa.load_wide(self.0, group);
            (low, high) = (low.min(lanes.least()), high.max(lanes.greatest()));
        }
        (rows, [low, high])
    }
}

#[test]
fn the_least_and_greatest_lane() {
    let mut random = Random(2);
    for _ in 0..3000 {
        let mut number = || loop {
            let value = random.nasty();
            if !value.is_nan() {
                return value;
            }
        };
        let rows = bundle_row(&mut number);
        // Zeros of either sign are equal here.
        let (each, all) = agreed(&Extremes(&rows), "");
        let extremes = |lanes: &[f32]| {
            let sorted = |pick: fn(f32, f32) -> f32| lanes.iter().copied().reduce(pick);
            [sorted(f32::min), sorted(f32::max)].map(|found| found.expect("there are lanes"))
        };
        for (row, found) in rows.0.chunks(WIDTH).zip(each) {
            assert_eq!(found, extremes(row));
        }
        assert_eq!(all, extremes(&rows.0));
    }
}

#[derive(Clone, Copy)]
struct Splat(f32);

impl Task for Splat {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Vec<u32> {
        let narrow = isa.splat(self.0);
        let again = narrow.splat(self.0);
        let mut rows = BundleRow::splat(7.0);
        for group in 0..BUNDLE_RAYS / I::WIDE {
            isa.store_wide(isa.load_wide(&rows, group).splat(self.0), &mut rows, group);
        }
        let lanes = [narrow.to_array(), again.to_array()];
        lanes.as_flattened().iter().chain(&rows.0).map(|x| x.to_bits()).collect()
    }
}

#[test]
fn one_number_fills_all_lanes() {
    for value in NASTY {
        let lanes = agreed(&Splat(value), "");
        assert_eq!(lanes, vec![value.to_bits(); 2 * WIDTH + BUNDLE_RAYS]);
    }
}

#[derive(Clone, Copy)]
struct Push<'a> {
    children: &'a Row,
    enter: &'a Row,
    exit: &'a Row,
    octant: Octant,
}

impl Task for Push<'_> {
    type Output = (Vec<[u32; 2]>, Pushed);

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let interval = Interval { enter: isa.load(self.enter), exit: isa.load(self.exit) };
        let (mut children, mut enters) = ([7.0; WIDTH], [7.0; WIDTH]);
        let window = Window { children: &mut children, enters: &mut enters };
        let pushed = isa.push::<true>(self.children, interval, Order::of(self.octant), window);
        let mut alone = [7.0; WIDTH];
        let window = Window { children: &mut alone, enters: &mut [7.0; WIDTH] };
        assert_eq!(isa.push::<false>(self.children, interval, Order::of(self.octant), window), pushed);
        let both = |place: usize| [children[place], enters[place]].map(f32::to_bits);
        let found = (0..pushed.count()).map(both).collect::<Vec<_>>();
        assert!((0..pushed.count()).all(|place| alone[place].to_bits() == found[place][0]));
        (found, pushed)
    }
}

/// Where a box that is met is entered and left, and where one that is not.
fn interval(random: &mut Random, met: bool) -> [f32; 2] {
    let (a, b) = (random.signed(), random.signed());
    match (met, random.below(4)) {
        (true, 0) => [a, a],
        (true, 1) => [0.0, -0.0],
        (true, 2) => [f32::NEG_INFINITY, f32::INFINITY],
        (true, _) => [a.min(b), a.max(b)],
        (false, 0) => [f32::NAN, b],
        (false, 1) => [a, f32::NAN],
        (false, 2) => [f32::INFINITY, f32::NEG_INFINITY],
        (false, _) => [a.max(b).next_up(), a.min(b)],
    }
}

#[test]
fn children_are_pushed_from_far_to_near() {
    let mut random = Random(3);
    for mask in 0..256_u32 {
        for octant in 0..8 {
            let mut rows = [row(|| f32::from_bits(random.bits() as u32)), Row::splat(0.0), Row::splat(0.0)];
            for lane in 0..WIDTH {
                let [enter, exit] = interval(&mut random, mask >> lane & 1 == 1);
                (rows[1].0[lane], rows[2].0[lane]) = (enter, exit);
            }
            let [children, enter, exit] = &rows;
            let named = Octant::new([0, 1, 2].map(|axis| octant >> axis & 1 == 1));
            assert_eq!(named.index(), octant);
            let (pushed, set) = agreed(&Push { children, enter, exit, octant: named }, "");
            let mut lanes: Vec<usize> = (0..WIDTH).filter(|lane| mask >> lane & 1 == 1).collect();
            lanes.sort_by_key(|lane| std::cmp::Reverse(lane ^ octant));
            let expected: Vec<[u32; 2]> =
                lanes.iter().map(|&lane| [children.0[lane], enter.0[lane]].map(f32::to_bits)).collect();
            assert_eq!(pushed, expected, "mask {mask:b}, octant {octant}");
            if let Some(&last) = lanes.last() {
                assert_eq!(set.last_lane(named), last, "mask {mask:b}, octant {octant}");
            }
        }
    }
    assert_eq!(Octant::ASCENDING, Octant::new([true; 3]));
}
