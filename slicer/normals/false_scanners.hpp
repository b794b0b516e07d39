#pragma once
/// Finds scanners that can't have stood where the file says.

#include "slicer/cloud/cloud.hpp"
#include "slicer/cloud/kd_tree.hpp"

namespace plumbline::inline slicer {

/// Forgets a scanner's place if it can't have seen its points from there: other surface hides two fifths of them. Programs that merge clouds
/// often write one scanner's place for all points. A scanner inside what it has seen, as in a room, is always believed.
/// @param cloud  in the order of `tree`
void forget_false_scanners(Cloud& cloud, const KdTree3& tree);

}  // namespace plumbline::inline slicer
