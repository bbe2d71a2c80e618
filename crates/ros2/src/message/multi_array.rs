//! `std_msgs/Float32MultiArray`.

use super::message;

message! {
    /// A dimension of an array.
    MultiArrayDimension = "std_msgs/MultiArrayDimension" {
        /// What it counts.
        label: String,
        /// Elements in it.
        size: u32,
        /// Numbers in this dimension and all after it.
        stride: u32,
    }
}

message! {
    /// The dimensions of an array.
    MultiArrayLayout = "std_msgs/MultiArrayLayout" {
        /// From the outermost in.
        dim: Vec<MultiArrayDimension>,
        /// Numbers before the first of the array.
        data_offset: u32,
    }
}

message! {
    /// An array of numbers.
    Float32MultiArray = "std_msgs/Float32MultiArray" {
        /// Its dimensions.
        layout: MultiArrayLayout,
        /// Its numbers.
        data: Vec<f32>,
    }
}
