//! Longest-edge bisection until no edge is longer than asked (Rivara 1984), without T-junctions.
//!
//! In each round every over-long edge is marked; a triangle with a marked edge marks its longest edge too, until
//! nothing changes; then each triangle is cut at its longest edge, and the halves at the one marked edge they have
//! left. Edges are known by their end *positions*, so that triangles on both sides of a crease are cut together.

use std::cmp::Ordering;

use glam::{Vec2, Vec3};

use super::{Element, NumberMap, Vertices, check_count};

/// Shortest `max_edge` in local units: well above the resolution of an f32 near 1, so that bisection always ends.
const SHORTEST: f64 = 1e-5;

/// A node of the bisection forest. The upper two bits are the edge that was cut (edge k joins corners k and k+1) and
/// the others the first of two children, or they are [`LEAF`] and the element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node(u32);

const LEAF: u32 = 3;

impl Node {
    fn new(tag: u32, index: u32) -> Self {
        Self(tag << 30 | index)
    }

    fn tag(self) -> u32 {
        self.0 >> 30
    }

    fn index(self) -> u32 {
        self.0 & (u32::MAX >> 2)
    }
}

/// The element below a node (the roots come first) that holds a point, and the point's barycentric coordinates in it.
pub(super) fn descend(nodes: &[Node], start: u32, barycentric: Vec2) -> (u32, Vec2) {
    let mut weights = [1.0 - barycentric.x - barycentric.y, barycentric.x, barycentric.y];
    let mut node = nodes[start as usize];
    while node.tag() != LEAF {
        let edge = node.tag() as usize;
        let [a, b, c] = [weights[edge], weights[(edge + 1) % 3], weights[(edge + 2) % 3]];
        // a A + b B + c C with M = (A + B) / 2, in the half (A, M, C) or (M, B, C).
        let second = b > a;
        weights = if second { [2.0 * a, b - a, c] } else { [a - b, 2.0 * b, c] };
        node = nodes[node.index() as usize + usize::from(second)];
    }
    (node.index(), Vec2::new(weights[1], weights[2]))
}

/// Bisects until no edge is longer than `longest` [local units]; returns the elements and the forest, whose first
/// nodes are the roots: one for each element that came in.
pub(super) fn bisect(
    elements: Vec<Element>,
    vertices: &mut Vertices,
    longest: f64,
) -> Result<(Vec<Element>, Vec<Node>), String> {
    if longest.is_nan() || longest < SHORTEST {
        return Err(format!("is not a usable length; it must be at least {SHORTEST} of the scene's size"));
    }
    let longest_squared = (longest * longest) as f32;
    check_count(fewest_elements(&elements, vertices, longest))?;
    let mut cutter = Cutter::new(elements, vertices);
    while cutter.mark_long(longest_squared) {
        check_count(cutter.count_after_cut())?;
        cutter.cut(vertices);
    }
    Ok(cutter.finish())
}

/// The least number of elements whose edges are no longer than `longest`: no such triangle has more area than the
/// equilateral one.
fn fewest_elements(elements: &[Element], vertices: &Vertices, longest: f64) -> u64 {
    let area = |element: &Element| {
        let [a, b, c] = element.vertices.map(|vertex| vertices.positions[vertex as usize]);
        f64::from(0.5 * (b - a).cross(c - a).length())
    };
    let total: f64 = elements.iter().map(area).sum();
    (total / (0.75_f64.sqrt() / 2.0 * longest * longest)) as u64
}

/// One triangle of the current round.
#[derive(Clone, Copy)]
pub(super) struct Item {
    pub(super) element: Element,
    /// Edge k joins corners k and k+1.
    edges: [u32; 3],
    pub(super) node: u32,
}

struct Edge {
    /// Position numbers, the lower first.
    ends: [u32; 2],
    squared_length: f32,
    marked: bool,
}

pub(super) struct Cutter {
    pub(super) items: Vec<Item>,
    pub(super) nodes: Vec<Node>,
    edges: Vec<Edge>,
    edge_numbers: NumberMap<[u32; 2]>,
    /// Number of each position, by its bits.
    position_numbers: NumberMap<[u32; 3]>,
    /// The position number of each vertex.
    position_of: Vec<u32>,
}

impl Cutter {
    pub(super) fn new(elements: Vec<Element>, vertices: &Vertices) -> Self {
        let mut cutter = Self {
            items: Vec::with_capacity(elements.len()),
            nodes: vec![Node(0); elements.len()],
            edges: Vec::new(),
            edge_numbers: NumberMap::default(),
            position_numbers: NumberMap::default(),
            position_of: Vec::new(),
        };
        cutter.number_positions(&vertices.positions);
        for (index, element) in elements.into_iter().enumerate() {
            let [a, b, c] = element.vertices;
            let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| cutter.edge(from, to, &vertices.positions));
            cutter.items.push(Item { element, edges, node: index as u32 });
        }
        cutter
    }

    /// Numbers the positions of the vertices that have come since the last call.
    fn number_positions(&mut self, positions: &[Vec3]) {
        for position in &positions[self.position_of.len()..] {
            let bits = (*position + Vec3::ZERO).to_array().map(f32::to_bits); // -0 becomes 0
            let next = self.position_numbers.len() as u32;
            self.position_of.push(*self.position_numbers.entry(bits).or_insert(next));
        }
    }

    /// The edge between two vertices, made if there is none yet.
    fn edge(&mut self, from: u32, to: u32, positions: &[Vec3]) -> u32 {
        let [a, b] = [from, to].map(|vertex| self.position_of[vertex as usize]);
        let ends = [a.min(b), a.max(b)];
        *self.edge_numbers.entry(ends).or_insert_with(|| {
            let squared_length = positions[from as usize].distance_squared(positions[to as usize]);
            self.edges.push(Edge { ends, squared_length, marked: false });
            (self.edges.len() - 1) as u32
        })
    }

    /// Which of an item's edges is the longest; ties are broken by the positions' numbers, so in the same way for
    /// all triangles around.
    pub(super) fn longest_edge(&self, item: &Item) -> usize {
        let order = |a: u32, b: u32| -> Ordering {
            let (a, b) = (&self.edges[a as usize], &self.edges[b as usize]);
            a.squared_length.total_cmp(&b.squared_length).then(a.ends.cmp(&b.ends))
        };
        let [first, second, third] = item.edges;
        let longer = if order(second, first).is_gt() { 1 } else { 0 };
        if order(third, item.edges[longer]).is_gt() { 2 } else { longer }
    }

    /// Marks the edges that are over-long, and what must be cut with them; false if there is none.
    fn mark_long(&mut self, longest_squared: f32) -> bool {
        let (starts, _) = self.items_around_edges();
        for (index, edge) in self.edges.iter_mut().enumerate() {
            let in_use = starts[index] < starts[index + 1];
            edge.marked = in_use && edge.squared_length > longest_squared;
        }
        self.mark_with_them()
    }

    /// Marks the longest edge of each of these items, and what must be cut with them; false if there is none.
    pub(super) fn mark_items(&mut self, items: &[u32]) -> bool {
        self.edges.iter_mut().for_each(|edge| edge.marked = false);
        for &item in items {
            let item = self.items[item as usize];
            let longest = item.edges[self.longest_edge(&item)];
            self.edges[longest as usize].marked = true;
        }
        self.mark_with_them()
    }

    /// Marks the longest edge of every item that has a marked edge; false if none is marked.
    fn mark_with_them(&mut self) -> bool {
        let (starts, around) = self.items_around_edges();
        let mut pending: Vec<usize> = (0..self.edges.len()).filter(|&edge| self.edges[edge].marked).collect();
        let any = !pending.is_empty();
        while let Some(edge) = pending.pop() {
            for &item in &around[starts[edge] as usize..starts[edge + 1] as usize] {
                let item = &self.items[item as usize];
                let longest = item.edges[self.longest_edge(item)] as usize;
                if !self.edges[longest].marked {
                    self.edges[longest].marked = true;
                    pending.push(longest);
                }
            }
        }
        any
    }

    /// The items around each edge e: `around[starts[e]..starts[e + 1]]`.
    fn items_around_edges(&self) -> (Vec<u32>, Vec<u32>) {
        let mut starts = vec![0_u32; self.edges.len() + 1];
        for edge in self.items.iter().flat_map(|item| item.edges) {
            starts[edge as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum; // the end of this edge's items, for now
        }
        let mut around = vec![0_u32; sum as usize];
        for (index, item) in self.items.iter().enumerate() {
            for edge in item.edges {
                starts[edge as usize] -= 1;
                around[starts[edge as usize] as usize] = index as u32;
            }
        }
        (starts, around)
    }

    pub(super) fn count_after_cut(&self) -> u64 {
        let marked = |item: &Item| item.edges.iter().filter(|&&edge| self.edges[edge as usize].marked).count();
        self.items.iter().map(|item| 1 + marked(item) as u64).sum()
    }

    /// Cuts all marked edges.
    pub(super) fn cut(&mut self, vertices: &mut Vertices) {
        vertices.midpoints.clear();
        let items = std::mem::take(&mut self.items);
        let is_marked = |cutter: &Self, item: &Item, edge: usize| cutter.edges[item.edges[edge] as usize].marked;
        let mut next = Vec::with_capacity(items.len() * 2);
        for item in items {
            let longest = self.longest_edge(&item);
            if !is_marked(self, &item, longest) {
                next.push(item);
                continue;
            }
            // The halves keep one whole edge of the triangle each: (C, A), third of the first, and (B, C), second.
            for (half, kept) in self.halves(item, longest, vertices).into_iter().zip([2, 1]) {
                if is_marked(self, &half, kept) {
                    next.extend(self.halves(half, kept, vertices));
                } else {
                    next.push(half);
                }
            }
        }
        self.items = next;
    }

    /// Cuts (A, B, C) at the middle M of its edge (A, B) into (A, M, C) and (M, B, C); `edge` says which corner is A.
    fn halves(&mut self, item: Item, edge: usize, vertices: &mut Vertices) -> [Item; 2] {
        let corners = [edge, (edge + 1) % 3, (edge + 2) % 3];
        let [a, b, c] = corners.map(|corner| item.element.vertices[corner]);
        let [p, q, r] = corners.map(|corner| item.element.barycentrics[corner]);
        let [_, edge_bc, edge_ca] = corners.map(|corner| item.edges[corner]);
        let m = vertices.midpoint(a, b);
        let middle = 0.5 * (p + q);
        self.number_positions(&vertices.positions);
        let [edge_am, edge_mb, edge_mc] =
            [(a, m), (m, b), (m, c)].map(|(from, to)| self.edge(from, to, &vertices.positions));

        let first = self.nodes.len() as u32;
        self.nodes[item.node as usize] = Node::new(edge as u32, first);
        self.nodes.extend([Node(0); 2]);
        let half = |vertices, barycentrics, edges, node| Item {
            element: Element { vertices, barycentrics, ..item.element },
            edges,
            node,
        };
        [
            half([a, m, c], [p, middle, r], [edge_am, edge_mc, edge_ca], first),
            half([m, b, c], [middle, q, r], [edge_mb, edge_bc, edge_mc], first + 1),
        ]
    }

    /// Makes each item a leaf of the forest.
    pub(super) fn name_leaves(&mut self) {
        for (index, item) in self.items.iter().enumerate() {
            self.nodes[item.node as usize] = Node::new(LEAF, index as u32);
        }
    }

    fn finish(mut self) -> (Vec<Element>, Vec<Node>) {
        self.name_leaves();
        (self.items.iter().map(|item| item.element).collect(), self.nodes)
    }
}
