//! Disjoint sets of numbers: who is connected with whom.

/// Sets of the numbers from 0 on, at first one each (union-find with path halving; Tarjan and van Leeuwen 1984).
pub struct Sets {
    parents: Vec<u32>,
}

impl Sets {
    /// So many sets of one number each.
    pub fn of_one(count: u32) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// Makes one set of those of two numbers.
    pub fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.lowest(one), self.lowest(other));
        self.parents[one.max(other) as usize] = one.min(other);
    }

    /// The lowest number of each number's set.
    pub fn into_lowest(mut self) -> Vec<u32> {
        (0..self.parents.len() as u32).map(|member| self.lowest(member)).collect()
    }

    fn lowest(&mut self, mut member: u32) -> u32 {
        let parents = &mut self.parents;
        while parents[member as usize] != member {
            let above = parents[parents[member as usize] as usize];
            parents[member as usize] = above;
            member = above;
        }
        member
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_knows_the_lowest_of_its_set_whatever_the_order_of_joining() {
        for pairs in [[[4, 2], [5, 4], [1, 0]], [[1, 0], [4, 5], [2, 5]]] {
            let mut sets = Sets::of_one(6);
            pairs.into_iter().for_each(|[one, other]| sets.join(one, other));
            assert_eq!(sets.into_lowest(), [0, 0, 2, 3, 2, 2]);
        }
    }
}
