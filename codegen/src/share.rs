//! Shares pairs of factors or terms that occur in several products or sums.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use crate::graph::{Graph, Id, Op, Signed};

/// Creates a graph that computes the values at `roots` with shared pairs; returns it with the new indices of the roots.
pub fn share_pairs(graph: &Graph, roots: &[Signed]) -> (Graph, Vec<Signed>) {
    let mut lists = BTreeMap::new();
    for id in graph.reachable(roots.iter().map(|r| r.id)) {
        match graph.op(id) {
            Op::Product(factors) => {
                let elements = factors.iter().map(|&id| Signed { negative: false, id }).collect();
                lists.insert(id, (Kind::Product, elements));
            }
            Op::Sum(terms) if terms.len() > 1 => {
                lists.insert(id, (Kind::Sum, terms.clone()));
            }
            _ => {}
        }
    }
    let mut sharing = Sharing::new(lists, graph.ops().len());
    while sharing.round() {}
    let mut rebuilt = Rebuilt { old: graph, sharing: &sharing, new: Graph::default(), places: HashMap::new() };
    let roots = roots.iter().map(|root| Signed { negative: root.negative, id: rebuilt.build(root.id) }).collect();
    (rebuilt.new, roots)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Kind {
    Product,
    Sum,
}

/// Two elements of a list, and whether their signs differ.
type Pair = (Kind, Id, Id, bool);

/// The order in which pairs are replaced: the number of lists with the pair, whether no list equals the pair, and the
/// pair.
type Rank = (Reverse<usize>, bool, Pair);

struct Sharing {
    lists: BTreeMap<Id, (Kind, Vec<Signed>)>,
    /// The elements that occur in one list only: no pair with them can be shared.
    single: HashSet<(Kind, Id)>,
    /// The lists that contain each pair.
    holders: HashMap<Pair, BTreeSet<Id>>,
    /// The pairs that more than one list contains.
    shared: HashSet<Pair>,
    made: Vec<Pair>,
    first_made: Id,
}

impl Sharing {
    fn new(lists: BTreeMap<Id, (Kind, Vec<Signed>)>, first_made: Id) -> Self {
        let mut holders: HashMap<(Kind, Id), usize> = HashMap::new();
        for (kind, elements) in lists.values() {
            let distinct: BTreeSet<Id> = elements.iter().map(|element| element.id).collect();
            distinct.into_iter().for_each(|id| *holders.entry((*kind, id)).or_default() += 1);
        }
        let single = holders.into_iter().filter(|(_, count)| *count == 1).map(|(element, _)| element).collect();
        let ids: Vec<Id> = lists.keys().copied().collect();
        let mut sharing =
            Self { lists, single, holders: HashMap::new(), shared: HashSet::new(), made: Vec::new(), first_made };
        ids.into_iter().for_each(|id| sharing.note(id));
        sharing
    }

    /// Replaces the most common pairs; returns whether any was replaced.
    fn round(&mut self) -> bool {
        let best = self.shared.iter().map(|pair| self.holders[pair].len()).max().unwrap_or(0);
        // Pairs far below the best of this round wait, since replacements create better ones.
        let is_near = |at: &BTreeSet<Id>| at.len() * 2 >= best;
        let near = self.shared.iter().map(|pair| (*pair, &self.holders[pair])).filter(|(_, at)| is_near(at));
        // Among equals, prefer a pair that is computed anyway.
        let is_whole = |at: &BTreeSet<Id>| at.iter().any(|id| self.lists[id].1.len() == 2);
        let mut candidates: Vec<(Rank, Vec<Id>)> =
            near.map(|(pair, at)| ((Reverse(at.len()), !is_whole(at), pair), at.iter().copied().collect())).collect();
        candidates.sort_unstable_by_key(|(rank, _)| *rank);
        let mut changed = BTreeSet::new();
        for ((.., pair), at) in candidates {
            let holds = |id: &Id| places_of(&self.lists[id].1, pair).is_some();
            let at: Vec<Id> = at.into_iter().filter(holds).collect();
            if at.len() < 2 || at.len() * 2 < best {
                continue;
            }
            let made = self.first_made + self.made.len();
            self.made.push(pair);
            for id in at {
                if changed.insert(id) {
                    self.forget(id);
                }
                if let Some((_, elements)) = self.lists.get_mut(&id) {
                    replace(elements, pair, made);
                }
            }
        }
        changed.iter().for_each(|&id| self.note(id));
        !changed.is_empty()
    }

    /// Registers the pairs of a list.
    fn note(&mut self, id: Id) {
        for pair in self.pairs(id) {
            let at = self.holders.entry(pair).or_default();
            at.insert(id);
            if at.len() == 2 {
                self.shared.insert(pair);
            }
        }
    }

    /// Unregisters the pairs of a list.
    fn forget(&mut self, id: Id) {
        for pair in self.pairs(id) {
            let Some(at) = self.holders.get_mut(&pair) else { continue };
            at.remove(&id);
            if at.len() == 1 {
                self.shared.remove(&pair);
            }
        }
    }

    /// The pairs in a list that other lists may contain too.
    fn pairs(&self, id: Id) -> BTreeSet<Pair> {
        let (kind, elements) = &self.lists[&id];
        let elements: Vec<&Signed> = elements.iter().filter(|e| !self.single.contains(&(*kind, e.id))).collect();
        let mut found = BTreeSet::new();
        for (i, a) in elements.iter().enumerate() {
            for b in &elements[i + 1..] {
                let (low, high) = if a.id <= b.id { (a, b) } else { (b, a) };
                found.insert((*kind, low.id, high.id, low.negative != high.negative));
            }
        }
        found
    }
}

/// The positions of a pair in a list.
fn places_of(elements: &[Signed], (_, low, high, opposite): Pair) -> Option<(usize, usize)> {
    elements.iter().enumerate().filter(|(_, e)| e.id == low).find_map(|(first, e)| {
        let partner =
            |(place, p): (usize, &Signed)| place != first && p.id == high && (p.negative != e.negative) == opposite;
        elements.iter().enumerate().position(partner).map(|second| (first, second))
    })
}

/// Replaces all occurrences of a pair by its value.
fn replace(elements: &mut Vec<Signed>, pair: Pair, made: Id) {
    while let Some((first, second)) = places_of(elements, pair) {
        // A list that equals the pair becomes a single value; elsewhere two elements become one.
        let negative = elements[first].negative && pair.0 == Kind::Sum;
        elements.remove(first.max(second));
        elements.remove(first.min(second));
        elements.push(Signed { negative, id: made });
    }
}

struct Rebuilt<'a> {
    old: &'a Graph,
    sharing: &'a Sharing,
    new: Graph,
    places: HashMap<Id, Id>,
}

impl Rebuilt<'_> {
    fn build(&mut self, id: Id) -> Id {
        if let Some(&place) = self.places.get(&id) {
            return place;
        }
        let op = if id >= self.sharing.first_made {
            let (kind, low, high, opposite) = self.sharing.made[id - self.sharing.first_made];
            let elements = [Signed { negative: false, id: low }, Signed { negative: opposite, id: high }];
            self.list(kind, &elements)
        } else {
            match (self.sharing.lists.get(&id), self.old.op(id)) {
                (Some((kind, elements)), _) => self.list(*kind, elements),
                (None, Op::Sum(terms)) => self.list(Kind::Sum, terms),
                (None, Op::Reciprocal(a)) => Op::Reciprocal(self.build(*a)),
                (None, Op::Power(a, exponent)) => Op::Power(self.build(*a), *exponent),
                (None, Op::Call(function, a)) => Op::Call(*function, self.build(*a)),
                (None, leaf) => leaf.clone(),
            }
        };
        let place = match op {
            // The whole list was a single shared pair.
            Op::Product(ref factors) if factors.len() == 1 => factors[0],
            Op::Sum(ref terms) if terms.len() == 1 && !terms[0].negative => terms[0].id,
            op => self.new.add(op),
        };
        self.places.insert(id, place);
        place
    }

    fn list(&mut self, kind: Kind, elements: &[Signed]) -> Op {
        let built: Vec<Signed> =
            elements.iter().map(|e| Signed { negative: e.negative, id: self.build(e.id) }).collect();
        match kind {
            Kind::Product => {
                let mut factors: Vec<Id> = built.iter().map(|e| e.id).collect();
                factors.sort_by_key(|&id| !self.new.is_constant(id));
                Op::Product(factors)
            }
            Kind::Sum => Op::Sum(built),
        }
    }
}
