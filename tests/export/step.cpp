// Streams a CSV through an exported model, sample by sample: step MODEL.ts SAMPLES.csv > predictions.txt
// The CSV has a header and one column for each of the model's inputs, in their order. LibTorch alone, no Python.
#include <torch/script.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "step MODEL.ts SAMPLES.csv\n");
    return 2;
  }
  torch::NoGradGuard no_grad;
  torch::jit::Module model = torch::jit::load(argv[1]);
  torch::jit::Method step = model.get_method("step");
  model.get_method("reset")({});
  std::ifstream samples(argv[2]);
  std::string line, cell;
  std::getline(samples, line);  // the header
  while (std::getline(samples, line)) {
    std::vector<double> row;
    std::stringstream cells(line);
    while (std::getline(cells, cell, ',')) row.push_back(std::stod(cell));
    torch::Tensor x = torch::from_blob(row.data(), {static_cast<long>(row.size())}, torch::kFloat64);
    std::printf("%.17g\n", step({x}).toTensor().item<double>());
  }
  return 0;
}
