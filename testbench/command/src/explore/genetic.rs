//! NSGA-II: a population of designs from whose best the next ones are bred. K. Deb, A. Pratap, S. Agarwal and T. Meyarivan, *A fast and
//! elitist multiobjective genetic algorithm: NSGA-II*, 2002, with its simulated binary crossover and polynomial mutation.
//!
//! A member is a place of the unit cube, as the other methods have it. Those that are out lose against all that are not.

use super::criteria::front;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Members of a population.
pub const POPULATION: usize = 24;
/// How near children are to their parents, and mutants to what they were: the distribution indices of the paper.
const NEARNESS: [f64; 2] = [15.0, 20.0];
/// How often two parents are crossed.
const CROSSED: f64 = 0.9;

/// A place of the unit cube.
pub type Genes = Vec<f64>;

/// A member with what it has of each objective, each as small as it can be; nothing if it is out.
pub type Member = (Genes, Option<Vec<f64>>);

/// See the module's description.
pub struct Genetic {
    rng: ChaCha8Rng,
    genes: usize,
    /// The best so far, best first.
    parents: Vec<Member>,
}

impl Genetic {
    /// A population of members of so many genes.
    pub fn new(genes: usize, seed: u64) -> Genetic {
        Genetic { rng: ChaCha8Rng::seed_from_u64(seed), genes, parents: vec![] }
    }

    /// The next generation: at random at first.
    pub fn ask(&mut self) -> Vec<Genes> {
        if self.parents.is_empty() {
            let rng = &mut self.rng;
            let mut member = || (0..self.genes).map(|_| rng.random_range(0.0..1.0)).collect();
            return (0..POPULATION).map(|_| member()).collect();
        }
        let mut children = vec![];
        while children.len() < POPULATION {
            let (a, b) = (self.parent(), self.parent());
            for mut child in self.crossed(&a, &b) {
                self.mutate(&mut child);
                children.push(child);
            }
        }
        children
    }

    /// What came of a generation: the best of it and its parents are the next parents.
    pub fn tell(&mut self, generation: Vec<Member>) {
        let mut all = std::mem::take(&mut self.parents);
        all.extend(generation);
        self.parents = sorted(all);
        self.parents.truncate(POPULATION);
    }

    /// The better one of two at random.
    fn parent(&mut self) -> Genes {
        let mut place = || self.rng.random_range(0..self.parents.len());
        let best = place().min(place());
        self.parents[best].0.clone()
    }

    fn crossed(&mut self, a: &Genes, b: &Genes) -> [Genes; 2] {
        let mut children = [a.clone(), b.clone()];
        if self.rng.random_range(0.0..1.0) >= CROSSED {
            return children;
        }
        for k in 0..self.genes {
            // Each gene is crossed, or taken over, and goes to either child.
            if self.rng.random_range(0.0..1.0) < 0.5 {
                let spread = spread(self.rng.random_range(0.0..1.0), NEARNESS[0]);
                let (middle, half) = ((a[k] + b[k]) / 2.0, (a[k] - b[k]) / 2.0);
                children[0][k] = within(middle + spread * half);
                children[1][k] = within(middle - spread * half);
            }
            if self.rng.random_range(0.0..1.0) < 0.5 {
                let [first, second] = &mut children;
                std::mem::swap(&mut first[k], &mut second[k]);
            }
        }
        children
    }

    /// Changes one gene, on the average.
    fn mutate(&mut self, child: &mut Genes) {
        for gene in child {
            if self.rng.random_range(0.0..1.0) < 1.0 / self.genes as f64 {
                let share: f64 = self.rng.random_range(0.0..1.0);
                let power = 1.0 / (NEARNESS[1] + 1.0);
                let step = match share < 0.5 {
                    true => (2.0 * share).powf(power) - 1.0,
                    false => 1.0 - (2.0 - 2.0 * share).powf(power),
                };
                *gene = within(*gene + step);
            }
        }
    }
}

/// How much farther apart children are than their parents.
fn spread(share: f64, nearness: f64) -> f64 {
    let base = if share <= 0.5 { 2.0 * share } else { 1.0 / (2.0 - 2.0 * share) };
    base.powf(1.0 / (nearness + 1.0))
}

/// A gene, 0 or more and below 1.
fn within(gene: f64) -> f64 {
    gene.clamp(0.0, 1.0 - f64::EPSILON)
}

/// Best first: front by front, within one those that have more room around them first; at the end those that are out.
fn sorted(members: Vec<Member>) -> Vec<Member> {
    let (mut left, out): (Vec<Member>, Vec<Member>) =
        members.into_iter().partition(|(_, values)| values.is_some());
    let mut all = vec![];
    while !left.is_empty() {
        let values: Vec<Vec<f64>> = left.iter().filter_map(|(_, values)| values.clone()).collect();
        let mut on = front(&values).into_iter();
        let (best, rest) = left.into_iter().partition(|_| on.next().unwrap_or(false));
        left = rest;
        all.extend(by_room(best));
    }
    all.extend(out);
    all
}

/// By the crowding distance: the sum over objectives of how far the neighbours on either side are apart.
fn by_room(front: Vec<Member>) -> Vec<Member> {
    let values: Vec<&Vec<f64>> = front.iter().filter_map(|(_, values)| values.as_ref()).collect();
    let mut room = vec![0.0; front.len()];
    let objectives = 0..values.first().map_or(0, |first| first.len());
    let values = &values;
    for of in objectives.map(|objective| move |member: usize| values[member][objective]) {
        let mut order: Vec<usize> = (0..front.len()).collect();
        order.sort_by(|a, b| of(*a).total_cmp(&of(*b)));
        let (first, last) = (order[0], order[order.len() - 1]);
        let range = of(last) - of(first);
        room[first] = f64::INFINITY;
        room[last] = f64::INFINITY;
        for three in order.windows(3) {
            let apart = of(three[2]) - of(three[0]);
            room[three[1]] += if range > 0.0 { apart / range } else { 0.0 };
        }
    }
    let mut members: Vec<(f64, Member)> = room.into_iter().zip(front).collect();
    members.sort_by(|a, b| b.0.total_cmp(&a.0));
    members.into_iter().map(|(_, member)| member).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first test problem of E. Zitzler, K. Deb and L. Thiele, 2000, in six variables: its front is `1 - sqrt(x)`, where all other
    /// variables are 0.
    fn zdt1(genes: &Genes) -> Vec<f64> {
        let rest = 1.0 + 9.0 * genes[1..].iter().sum::<f64>() / (genes.len() - 1) as f64;
        vec![genes[0], rest * (1.0 - (genes[0] / rest).sqrt())]
    }

    #[test]
    fn it_finds_a_front_that_is_known() {
        let mut genetic = Genetic::new(6, 1);
        for _ in 0..120 {
            let members = genetic.ask().into_iter().map(|genes| {
                let values = zdt1(&genes);
                (genes, Some(values))
            });
            let members = members.collect();
            genetic.tell(members);
        }
        let far = |values: &Vec<f64>| values[1] - (1.0 - values[0].sqrt());
        let places: Vec<Vec<f64>> = genetic.parents.into_iter().filter_map(|(_, v)| v).collect();
        let mean = places.iter().map(far).sum::<f64>() / places.len() as f64;
        assert!((0.0..0.05).contains(&mean), "{mean} from the front");
        let mut across: Vec<f64> = places.iter().map(|values| values[0]).collect();
        across.sort_by(f64::total_cmp);
        let gap = across.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(across[0] < 0.05 && across[POPULATION - 1] > 0.9 && gap < 0.2, "{across:?}");
    }

    #[test]
    fn what_is_out_is_last_and_ends_are_kept() {
        let member = |values: Option<[f64; 2]>| (vec![], values.map(Vec::from));
        let all = vec![
            member(None),
            member(Some([2.0, 2.0])),
            member(Some([1.0, 1.9])),
            member(Some([0.0, 3.0])),
            member(Some([1.1, 1.8])),
            member(Some([3.0, 0.0])),
        ];
        let values: Vec<Option<Vec<f64>>> =
            sorted(all).into_iter().map(|(_, values)| values).collect();
        assert_eq!(values[0], Some(vec![0.0, 3.0]));
        assert_eq!(values[1], Some(vec![3.0, 0.0]));
        assert_eq!(values[4..], [Some(vec![2.0, 2.0]), None]);
    }
}
