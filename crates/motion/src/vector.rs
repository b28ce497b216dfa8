//! A direction and length on the ground.

use std::ops::{Add, Mul, Neg, Sub};

use openbench_core::MapPoint;

/// A displacement in metres or a velocity in m/s, along the axes of `map` or `base_link`; the field
/// or function that holds it says which.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vector2 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
}

impl Vector2 {
    /// No displacement.
    pub const ZERO: Self = Self { x: 0.0, y: 0.0 };

    /// A vector from its components.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// From the origin of `map` to a point.
    #[inline]
    pub const fn to(point: MapPoint) -> Self {
        Self {
            x: point.x,
            y: point.y,
        }
    }

    /// The point of `map` to which it leads from the origin.
    #[inline]
    pub const fn point(self) -> MapPoint {
        MapPoint::new(self.x, self.y)
    }

    /// Scalar product.
    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Third component of the vector product: positive if `other` is to the left.
    #[inline]
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Whether both components are finite and smaller than `most`.
    pub(crate) fn is_within(self, most: f64) -> bool {
        self.x.abs() < most && self.y.abs() < most
    }

    /// Its length.
    #[inline]
    pub fn norm(self) -> f64 {
        self.dot(self).sqrt()
    }
}

impl Add for Vector2 {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
        }
    }
}

impl Sub for Vector2 {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
        }
    }
}

impl Neg for Vector2 {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
        }
    }
}

impl Mul<f64> for Vector2 {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
        }
    }
}
