"""The benchmark as a command."""

from benchmarks.genetic_papers.report import main

if __name__ == '__main__':
    main()
