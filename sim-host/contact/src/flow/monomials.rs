//! Polynomials in several variables, cut off: which monomials are kept, and which products of two
//! of them are kept too.

/// The monomials that a truncated polynomial keeps: all up to a degree, and one more power of each
/// variable. Products beyond them are dropped. A polynomial is a list of coefficients in this
/// order.
#[derive(Clone, Debug)]
pub struct Monomials {
    /// Exponents of the variables, by increasing degree. The first is the constant.
    exponents: Vec<Vec<u32>>,
    /// For each monomial but the constant: the place of a factor, and the variable by which it is
    /// multiplied.
    factors: Vec<[usize; 2]>,
    /// Places of two factors and of their product.
    pub(super) products: Vec<[usize; 3]>,
}

impl Monomials {
    /// Creates the monomials of `variables` variables up to `degree`, and the powers `degree + 1`.
    pub fn new(variables: usize, degree: u32) -> Self {
        let mut exponents = vec![vec![]];
        for _ in 0..variables {
            let longer = |of: &Vec<u32>| (0..=degree + 1).map(|exponent| [&of[..], &[exponent]].concat()).collect::<Vec<_>>();
            exponents = exponents.iter().flat_map(longer).collect();
            exponents.retain(|of| of.iter().sum::<u32>() <= degree + 1);
        }
        exponents.retain(|of| of.iter().sum::<u32>() <= degree || of.contains(&(degree + 1)));
        exponents.sort_by_key(|of| of.iter().sum::<u32>());
        let mut monomials = Monomials { exponents, factors: Vec::new(), products: Vec::new() };
        for (n, a) in monomials.exponents.iter().enumerate() {
            for (m, b) in monomials.exponents.iter().enumerate() {
                let sum: Vec<u32> = a.iter().zip(b).map(|(a, b)| a + b).collect();
                monomials.products.extend(monomials.place(&sum).map(|place| [n, m, place]));
            }
        }
        for exponents in &monomials.exponents[1..] {
            let variable = exponents.iter().position(|exponent| *exponent > 0).unwrap_or(0);
            let mut factor = exponents.clone();
            factor[variable] -= 1;
            monomials.factors.extend(monomials.place(&factor).map(|place| [place, variable]));
        }
        monomials
    }

    /// Returns the exponents of every monomial.
    pub fn exponents(&self) -> &[Vec<u32>] {
        &self.exponents
    }

    /// Computes every monomial at these variables.
    pub fn evaluate(&self, variables: &[f64], values: &mut Vec<f64>) {
        values.clear();
        values.push(1.0);
        for &[place, variable] in &self.factors {
            values.push(values[place] * variables[variable]);
        }
    }

    /// Returns the number of products that a multiplication computes.
    pub fn products(&self) -> usize {
        self.products.len()
    }

    /// Returns the place of the monomial with these exponents, if it is kept.
    pub fn place(&self, exponents: &[u32]) -> Option<usize> {
        self.exponents.iter().position(|of| of == exponents)
    }
}
