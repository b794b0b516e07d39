#pragma once
/// Thins points that lie in lines until they are as far apart along the lines as the lines need.

#include <cstdint>

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// Averages points along the lines of a turntable, a laser or sections, where the nearest points of a point lie in its own line. All that
/// follows takes a number of nearest points for a neighbourhood, and of one line these show no surface.
///
/// A neighbourhood is wide enough if the second variance of its points is a quarter of the first: it then reaches the lines beside. Where
/// 20 points are too few, neighbours are averaged within a quarter of the radius that is wide enough. Normals are averaged with them.
///
/// @param cloud  in the order of `tree`; that of a scan without lines stays as it is
/// @returns points that have been averaged into others; unless it is 0 the tree is that of another cloud. The same for any number of threads
std::uint32_t even_out_lines(Cloud& cloud, const KdTree3& tree);

}  // namespace plumbline::inline slicer
