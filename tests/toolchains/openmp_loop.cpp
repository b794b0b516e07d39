// Two parallel loops: the second reads what the first wrote on other threads. With the argument "race" a third loop sums without a
// reduction. Shows that ThreadSanitizer understands our OpenMP run time and still reports a real race.
#include <cstdio>
#include <cstring>
#include <vector>

int main(int argc, char** argv) {
  constexpr int kCount = 100000;
  std::vector<int> values(kCount);
  long sum = 0;
#pragma omp parallel num_threads(4)
  {
#pragma omp for schedule(dynamic, 100)
    for (int i = 0; i < kCount; ++i) values[static_cast<std::size_t>(i)] = 1;
#pragma omp for schedule(dynamic, 100) reduction(+ : sum)
    for (int i = 0; i < kCount; ++i) sum += values[static_cast<std::size_t>(kCount - 1 - i)];
  }
  if (argc > 1 && std::strcmp(argv[1], "race") == 0) {
#pragma omp parallel for num_threads(4)
    for (int i = 0; i < kCount; ++i) sum += 1;
  }
  std::printf("%ld\n", sum);
  return sum == kCount ? 0 : 1;
}
