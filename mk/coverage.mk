# SPDX-License-Identifier: Apache-2.0
# Branch coverage by the C tests, which are built in a variant of their own. Tests of the simulator and of pusdump
# are not among them, because the required values are those of flight software; endurance tests take no new branches.

COVERING = $(filter-out test/unit/sim/% test/unit/pus/tool/% %_endurance.c,$(TESTS))
coverage: build/setup/check
	$(if $(strip $(call selected,$(COVERING))),,$(error ONLY=$(ONLY): no C unit test has this in its path))
	$(PARALLEL) COVERAGE=1 coverage-tests
	@find build/coverage -name '*.gcda' -delete
	@$(VENV) test/support/run_tests.py --jobs $(JOBS) --only '$(ONLY)' --no-pytest --variant build/coverage \
	    $(call selected,$(COVERING)) >build/coverage/tests.txt || \
	    { grep ':FAIL\|did not build\|FAILED' build/coverage/tests.txt; \
	      echo 'coverage: some tests failed: see make test'; }
	@$(VENV) test/lint/check_coverage.py --jobs $(JOBS) $(if $(UPDATE),--update) $(if $(ONLY),--no-marks)
coverage-tests: $(foreach t,$(call selected,$(COVERING)),$(call test_name,$t))
	@:
