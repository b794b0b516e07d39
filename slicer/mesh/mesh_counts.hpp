#pragma once
/// What was found in a mesh, in numbers.

#include <cstdint>

#include "slicer/reader/triangles/triangle.hpp"

namespace plumbline::inline slicer {

struct MeshCounts {
  std::uint64_t faces = 0;          ///< of all files
  std::uint64_t triangles = 0;      ///< faces with more than three corners are several
  std::uint64_t not_finite = 0;     ///< triangles left out: a coordinate is NaN, infinite or huge
  std::uint64_t flat = 0;           ///< triangles without area, which no ray can pass
  std::uint64_t vertices = 0;       ///< of indexed formats
  std::uint64_t most_vertices = 0;  ///< of a file
  double seen_area = 0;             ///< of all triangles from above, squared scan units; decides the number of hits
  std::uint64_t hits = 0;           ///< of rays and triangles
  bool closed = false;              ///< every edge runs as often one way as the other
  std::uint64_t turned = 0;         ///< triangles that were turned over, so that they face as their shells do
  std::uint64_t dropped = 0;        ///< triangles left out: they are there more than once, or cancel each other
  UnusedSettings project;           ///< of a slicer, that some files are
  std::uint64_t closed_holes = 0;   ///< small ones, and faces that are turned over or there twice: close_small_holes()
  std::uint64_t rays = 0;           ///< that pass a triangle
  std::uint64_t broken_rays = 0;    ///< of these, those that enter and exit a different number of times
  std::uint64_t decided_rays = 0;   ///< of all rays, those of which the winding number decided a part
  std::uint64_t asked_rays = 0;     ///< of these, those along which it was computed; the rest lie between such rays
  std::uint64_t crowded_rays = 0;   ///< that have more crossings than can be stored; the upper ones are left out
};

}  // namespace plumbline::inline slicer
